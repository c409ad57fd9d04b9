//! An opened glTF file: its JSON, its buffers, and the pictures beside it.

use super::document::{Buffer, Document};
use super::{Problem, container, extensions, units};
use crate::LightUnits;
use crate::input::{Input, Scope};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use serde_json::Value;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// A glTF file with everything that it refers to at hand.
pub(super) struct Source {
    /// The JSON as it is in the file.
    pub(super) json: Value,
    /// The JSON as typed data.
    pub(super) document: Document,
    /// One entry per buffer, exactly `byteLength` long, or empty if its file is missing.
    pub(super) buffers: Vec<Vec<u8>>,
    /// The units of its lights' intensities.
    pub(super) light_units: LightUnits,
    folder: PathBuf,
    scope: Scope,
}

impl Source {
    /// Opens the file and the buffers beside it.
    pub(super) fn open(input: Input<'_>) -> Result<Self, Problem> {
        let scope = Scope::new(input);
        let bytes = scope.read(input.path)?;
        let parts = container::split(&bytes)?;
        let invalid = |error| format!("is not valid glTF 2.0: {error}; export the scene again");
        let json: Value = serde_json::from_slice(parts.json).map_err(invalid)?;
        let document = Document::deserialize(&json).map_err(invalid)?;
        check_version(&document)?;
        let folder = input.path.parent().unwrap_or(Path::new("")).to_owned();
        let buffers = load_buffers(&document, parts.bin, &folder, &scope)?;
        let light_units = units::of(&document.asset, input.light_units);
        Ok(Self { json, document, buffers, light_units, folder, scope })
    }

    /// What bounds the reading of this file.
    pub(super) fn scope(&self) -> &Scope {
        &self.scope
    }

    /// The bytes of buffer view `index`.
    pub(super) fn view(&self, index: usize) -> Result<&[u8], Problem> {
        let view = get(&self.document.buffer_views, index, "bufferView")?;
        let buffer = get(&self.buffers, view.buffer, "buffer")?;
        let end = view.byte_offset.checked_add(view.byte_length);
        end.and_then(|end| buffer.get(view.byte_offset..end)).ok_or_else(|| {
            format!(
                "bufferView {index} reaches beyond buffer {} of {} bytes; export the scene again",
                view.buffer,
                buffer.len()
            )
        })
    }

    /// Whether the accessor `index` counts in a buffer whose file is missing.
    pub(super) fn lacks(&self, index: usize) -> bool {
        let accessor = self.document.accessors.get(index);
        accessor.and_then(|accessor| accessor.buffer_view).is_some_and(|view| self.lacks_view(view))
    }

    fn lacks_view(&self, index: usize) -> bool {
        let buffer = self.document.buffer_views.get(index).map(|view| view.buffer);
        let is_empty = |buffer: usize| self.buffers.get(buffer).is_some_and(Vec::is_empty);
        let announced =
            |buffer: usize| self.document.buffers.get(buffer).map_or(0, |b| b.byte_length);
        buffer.is_some_and(|buffer| is_empty(buffer) && announced(buffer) > 0)
    }

    /// The encoded bytes (PNG, JPEG) of image `index`; none if its file is missing.
    pub(super) fn image(&self, index: usize) -> Result<Option<Cow<'_, [u8]>>, Problem> {
        let image = get(&self.document.images, index, "image")?;
        match (&image.uri, image.buffer_view) {
            (_, Some(view)) if self.lacks_view(view) => Ok(None),
            (_, Some(view)) => Ok(Some(Cow::Borrowed(self.view(view)?))),
            (Some(uri), None) => {
                let what = format!("image {index}");
                Ok(fetch(uri, &self.folder, &self.scope, &what)?.map(Cow::Owned))
            }
            (None, None) => {
                Err(format!("image {index} has neither uri nor bufferView; export the scene again"))
            }
        }
    }
}

impl Source {
    /// The bytes of the IES file of profile `index`; none if it is missing.
    pub(super) fn profile(&self, index: usize) -> Result<Option<Cow<'_, [u8]>>, Problem> {
        let profile = get(&self.document.extensions.profiles.lights, index, "profile")?;
        match (&profile.uri, profile.buffer_view) {
            (_, Some(view)) if self.lacks_view(view) => Ok(None),
            (_, Some(view)) => Ok(Some(Cow::Borrowed(self.view(view)?))),
            (Some(uri), None) => {
                let what = format!("profile {index} of EXT_lights_ies");
                Ok(fetch(uri, &self.folder, &self.scope, &what)?.map(Cow::Owned))
            }
            (None, None) => Err(format!(
                "profile {index} of EXT_lights_ies has neither uri nor bufferView; export the scene again"
            )),
        }
    }
}

/// Element `index` of `items`, or what is wrong.
pub(super) fn get<'a, T>(items: &'a [T], index: usize, what: &str) -> Result<&'a T, Problem> {
    items.get(index).ok_or_else(|| {
        format!("uses {what} {index}, but there are only {}; export the scene again", items.len())
    })
}

fn check_version(document: &Document) -> Result<(), Problem> {
    let version = &document.asset.version;
    if !version.starts_with("2.") {
        return Err(format!("is glTF {version}; export the scene as glTF 2.0"));
    }
    let required = &document.extensions_required;
    match required.iter().find(|name| !extensions::may_be_ignored(name)) {
        Some(name) => Err(extensions::refused(name)),
        None => Ok(()),
    }
}

fn load_buffers(
    document: &Document,
    bin: Option<&[u8]>,
    folder: &Path,
    scope: &Scope,
) -> Result<Vec<Vec<u8>>, Problem> {
    let mut buffers = Vec::new();
    for (index, buffer) in document.buffers.iter().enumerate() {
        let mut bytes = match (&buffer.uri, bin) {
            (Some(uri), _) => match fetch(uri, folder, scope, &format!("buffer {index}"))? {
                Some(bytes) => bytes,
                None => {
                    buffers.push(Vec::new());
                    continue;
                }
            },
            (None, Some(bin)) if index == 0 => bin.to_owned(),
            _ => return Err(no_data(index, buffer)),
        };
        if bytes.len() < buffer.byte_length {
            return Err(format!(
                "buffer {index} is cut short: {} bytes announced, {} there; export the scene again",
                buffer.byte_length,
                bytes.len()
            ));
        }
        bytes.truncate(buffer.byte_length);
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// The error for a buffer without data, which compression leaves for programs that do not know it.
fn no_data(index: usize, buffer: &Buffer) -> Problem {
    let compressed = buffer.unread.extensions.keys().next();
    let plain = || format!("buffer {index} has no data; export the scene again");
    compressed.map_or_else(plain, |name| extensions::refused(name))
}

/// What stands at `uri`: a data URI, or a file in or below `folder`; none if that is missing.
fn fetch(uri: &str, folder: &Path, scope: &Scope, what: &str) -> Result<Option<Vec<u8>>, Problem> {
    if let Some(data) = uri.strip_prefix("data:") {
        return decode_data(data).map(Some).ok_or_else(|| {
            format!("{what} is a data URI that is not valid base64; export the scene again")
        });
    }
    let scheme = uri.split(['/', '?', '#']).next().unwrap_or(uri);
    if scheme.contains(':') {
        return Err(format!(
            "{what} is at \"{uri}\"; only files beside the scene are read: copy it there"
        ));
    }
    let decoded = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let path = scope.find(folder, &decoded);
    path.and_then(|path| path.map(|path| scope.read(&path)).transpose()).map_err(|problem| {
        format!("{what} needs the file \"{decoded}\", which {problem}; put it beside the scene")
    })
}

fn decode_data(data: &str) -> Option<Vec<u8>> {
    let (head, body) = data.split_once(',')?;
    if head.ends_with(";base64") {
        STANDARD.decode(body.trim()).ok()
    } else {
        Some(percent_encoding::percent_decode_str(body).collect())
    }
}

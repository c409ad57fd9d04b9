//! Materials of USD: the prim, its pictures, and its two surfaces.
//!
//! Each surface reads the pictures by nodes of its own, as programs follow one of them: `preview.rs` and `openpbr.rs`.

use super::network::{Group, Network, Picture};
use super::stage::Prim;
use super::{openpbr, preview};
use crate::export::layered::{Layered, Transmission};
use crate::export::{Files, SceneView, maps, tiling};
use crate::glasses::Kind;
use crate::group_detail;
use crate::texels;
use unrender_scene::{Glass, Rgb, Warnings, Wrap};

/// What is left out of glass that is coloured in both ways.
const TINT_LEFT_OUT: &str = "USD's surfaces have one transmission colour: of solid glass that absorbs on the way and is tinted at \
                             its faces, the tint is left out; make transmission_color darker";

/// The material of group `index`, called `id`, below the path `parent`; its pictures are put among `files` under the paths
/// that `name` gives them.
///
/// # Errors
/// If a picture cannot be encoded.
pub(super) fn group(
    shot: &SceneView,
    index: usize,
    (parent, id): (&str, &str),
    name: &impl Fn(&str) -> String,
    files: &mut Files,
) -> Result<Prim, String> {
    let (group, material) = (&shot.scene.groups[index], &shot.materials[index]);
    let copies = tiling::copies(shot, index);
    let found = group_detail::of_group(shot.scene, index);
    let mut add = |what: &str, bytes: Vec<u8>, wraps: [Wrap; 2]| {
        let file = name(&format!("{id}{what}.exr"));
        let asset = format!("./{file}");
        files.push((file, bytes));
        Picture { asset, repeats: wraps.map(|wrap| wrap != Wrap::ClampToEdge) }
    };
    let texture = material.texture.as_ref().map(|texture| {
        let tile = tiling::tile(texture, copies);
        Ok::<_, String>(add("", texels::exr(&tile.image)?, [texture.wrap_u, texture.wrap_v]))
    });
    let texture = texture.transpose()?;
    let normals = found.normals.as_ref().map(|map| {
        let colors = maps::colors(map, false);
        let tile = tiling::tile(&colors, copies);
        let wraps = [colors.wrap_u, colors.wrap_v];
        Ok::<_, String>(add("-normals", texels::exr(&tile.image)?, wraps))
    });
    let normals = normals.transpose()?;
    let holes = found.coverage.as_ref().map(|coverage| {
        let alpha = tiling::tile(&coverage.alpha, copies).image;
        let bytes = texels::exr(&alpha.map(|alpha| Rgb::splat(*alpha)))?;
        let wraps = [coverage.alpha.wrap_u, coverage.alpha.wrap_v];
        Ok::<_, String>((add("-holes", bytes, wraps), coverage.cutoff))
    });
    let holes = holes.transpose()?;
    let (layered, emission) = (Layered::of(material), group.emission);
    let group = Group { material, layered, emission, texture, normals, holes };
    let mut network = Network::new(parent, id, &shot.scene.groups[index].name);
    let surface = preview::group(&group, &mut network);
    network.prim.connect("token", "outputs:surface", surface);
    let surface = openpbr::group(&group, &mut network);
    network.prim.connect("token", "outputs:mtlx:surface", surface);
    Ok(network.prim)
}

/// The material of a kind of glass, called `id`, below the path `parent`.
pub(super) fn glass(kind: &Kind, (parent, id): (&str, &str), warnings: &mut Warnings) -> Prim {
    let glass: &Glass = kind.glass;
    let transmission = Transmission::of(glass);
    if transmission.lacks_tint {
        warnings.push(TINT_LEFT_OUT);
    }
    let mut network = Network::new(parent, id, &kind.name);
    let surface = preview::glass(glass, &mut network);
    network.prim.connect("token", "outputs:surface", surface);
    let surface = openpbr::glass(glass, transmission, &mut network);
    network.prim.connect("token", "outputs:mtlx:surface", surface);
    network.prim
}

//! Files that are meant to do harm: none is read beyond its folder, its memory or its time.
//! `tests/data/hostile` has the findings of earlier searches.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;
use unrender_formats::{Input, Limits, load_scene, picture};

/// No input takes longer, however it is made.
const PATIENCE: Duration = Duration::from_secs(60);

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hostile")
}

/// What `load_scene` or `picture::read` says of `path`, on a thread with a small stack.
fn told(path: PathBuf) -> Result<(), String> {
    let (sender, receiver) = mpsc::channel();
    let name = path.display().to_string();
    std::thread::Builder::new()
        .stack_size(2 << 20)
        .spawn(move || {
            let limits = Limits { memory: 512 << 20, ..Limits::default() };
            let is_picture = |e: &str| ["png", "jpg", "exr", "hdr", "tif"].contains(&e);
            let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            let input = Input::new(&path, limits);
            let result = if is_picture(&extension) {
                picture::read(input).map(|_| ())
            } else {
                load_scene(input).map(|_| ())
            };
            // The receiver may have timed out.
            let _ = sender.send(result.map_err(|error| error.to_string()));
        })
        .unwrap();
    receiver.recv_timeout(PATIENCE).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn refusal(path: PathBuf) -> String {
    let name = path.display().to_string();
    told(path).expect_err(&name)
}

#[test]
fn all_findings_end() {
    for entry in fs::read_dir(data()).unwrap() {
        // It may be read or refused, but soon and without a panic.
        let _ = told(entry.unwrap().path());
    }
}

#[test]
fn references_do_not_leave_the_folder() {
    for name in
        ["uri_abs", "uri_up", "uri_dev", "uri_dir", "img_abs", "img_up", "img_dev", "img_pct"]
    {
        let said = refusal(data().join(format!("{name}.gltf")));
        let is_refused = ["--allow-outside", "regular file", "is missing"];
        assert!(is_refused.iter().any(|words| said.contains(words)), "{name}: {said}");
    }
    for name in ["abs.rad", "dev.rad"] {
        let said = refusal(data().join(name));
        assert!(said.contains("--allow-outside"), "{said}");
        assert!(!said.contains("root:"), "shows what it should not have read: {said}");
    }
}

#[test]
fn references_to_the_outside_can_be_allowed() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("scene")).unwrap();
    let main = folder.path().join("scene/main.rad");
    fs::write(
        folder.path().join("part.rad"),
        "void light l 0 0 3 1 1 1\nl sphere s 0 0 4 0 0 0 1\n",
    )
    .unwrap();
    fs::write(&main, "!xform ../part.rad\n").unwrap();
    assert!(load_scene(&main).unwrap_err().to_string().contains("--allow-outside"));
    let limits = Limits { outside: true, ..Limits::default() };
    assert_eq!(load_scene(Input::new(&main, limits)).unwrap().0.objects.len(), 1);
}

#[cfg(unix)]
#[test]
fn links_and_pipes_are_seen_through() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::os::unix::fs::symlink("/etc/passwd", path("link.mtl")).unwrap();
    fs::write(path("a.obj"), "mtllib link.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert!(refusal(path("a.obj")).contains("--allow-outside"));
    let made = std::process::Command::new("mkfifo").arg(path("fifo.ply")).status().unwrap();
    assert!(made.success());
    let shape = "<shape type=\"ply\"><string name=\"filename\" value=\"fifo.ply\"/></shape>";
    fs::write(path("b.xml"), format!("<scene version=\"3.0.0\">{shape}</scene>")).unwrap();
    assert!(refusal(path("b.xml")).contains("regular file"));
}

#[test]
fn counts_are_checked_before_memory_is_asked_for() {
    assert!(refusal(data().join("mem85.exr")).contains("cannot hold"));
    assert!(refusal(data().join("tile.exr")).contains("blocks of 64 x 8388608 pixels"));
    assert!(refusal(data().join("tile-overflow.exr")).contains("cannot hold"));
    assert!(refusal(data().join("plyn.xml")).contains("cannot hold"));
    assert!(refusal(data().join("plye.xml")).contains("cannot hold"));
    assert!(refusal(data().join("prog4600.jpg")).contains("cannot hold"));
    assert!(refusal(data().join("p16000.png")).contains("cannot hold"));
    assert!(refusal(data().join("r0.rad")).contains("more than 1000 files"));
}

#[test]
fn nested_elements_do_not_end_the_process() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep.xml");
    let depth = 100_000;
    let inside = "<bsdf type=\"twosided\">".repeat(depth) + &"</bsdf>".repeat(depth);
    fs::write(&path, format!("<scene version=\"3.0.0\">{inside}</scene>")).unwrap();
    assert!(refusal(path).contains("100 deep"));
}

#[test]
fn instances_of_instances_are_refused_soon() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.gltf");
    let triangles = 20_000;
    let indices: Vec<u8> =
        (0..3 * triangles).flat_map(|_| [0u8, 1, 2]).take(3 * triangles).collect();
    let positions: Vec<u8> =
        [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|v| v.to_le_bytes()).collect();
    let length = positions.len() + indices.len();
    fs::write(folder.path().join("b.bin"), [positions, indices].concat()).unwrap();
    let json = serde_json::json!({
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "b.bin", "byteLength": length}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36},
                        {"buffer": 0, "byteOffset": 36, "byteLength": 3 * triangles}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5121, "count": 3 * triangles, "type": "SCALAR"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": vec![serde_json::json!({"mesh": 0}); 20_000],
    });
    fs::write(&path, json.to_string()).unwrap();
    assert!(refusal(path).contains("--input-memory"));
}

#[test]
fn a_profile_that_unpacks_to_gigabytes_is_refused() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("profile.png");
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    let zeros = vec![0u8; 1 << 20];
    (0..400).for_each(|_| packed.write_all(&zeros).unwrap());
    let profile = [b"p\0\0".as_slice(), &packed.finish().unwrap()].concat();
    let mut bytes = fs::read(data().join("tex.png")).unwrap();
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        let mut crc = flate2::Crc::new();
        crc.update(kind);
        crc.update(data);
        [&(data.len() as u32).to_be_bytes(), kind.as_slice(), data, &crc.sum().to_be_bytes()]
            .concat()
    };
    // After the header.
    bytes.splice(33..33, chunk(b"iCCP", &profile));
    fs::write(&path, bytes).unwrap();
    // Refused, or read without it.
    if let Err(said) = told(path) {
        assert!(said.contains("profile"), "{said}");
    }
}

#[test]
fn honest_but_too_large_pictures_say_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.png");
    let size = 7000;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size, size);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&vec![0; (size * size) as usize]).unwrap();
    writer.finish().unwrap();
    fs::write(&path, bytes).unwrap();
    let said = refusal(path.clone());
    assert!(said.contains("7000 x 7000") && said.contains("--input-memory"), "{said}");
    assert!(picture::read(&path).is_ok(), "49 million pixels are read by default");
}

#[test]
fn one_name_for_many_materials_is_no_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("names.gltf");
    let json = serde_json::json!({
        "asset": {"version": "2.0"},
        "materials": vec![serde_json::json!({"name": "a"}); 50_000],
    });
    fs::write(&path, json.to_string()).unwrap();
    let _ = told(path);
}

//! Both writers and the packer, by small stages whose files are known.

use super::stage::{Prim, Stage, Value};
use super::{binary, lights, openpbr, package, packed, text};
use glam::{DMat4, Vec2, Vec3};
use std::collections::BTreeMap;

/// One of each kind of value, property and field.
fn stage() -> Stage {
    let mut surface = Prim::new("Shader", "surface");
    surface.set_uniform("token", "info:id", Value::token("UsdPreviewSurface"));
    surface.set("color3f", "inputs:diffuseColor", Value::Float3(Vec3::new(0.5, 0.1, 0.0)));
    surface.set("float4", "inputs:scale", Value::Float4([2.0, 2.0, 2.0, 1.0]));
    surface.set("asset", "inputs:file", Value::Asset("./a b@c.exr".into()));
    surface.declare("token", "outputs:surface");
    let mut material = Prim::new("Material", "m").named("a \"b\"\n\\ é");
    material.connect("token", "outputs:surface", "/scene/m/surface.outputs:surface".into());
    material.children.push(surface);
    let mut mesh = Prim::new("Mesh", "o").with_schema("MaterialBindingAPI");
    mesh.set_uniform("bool", "doubleSided", Value::Bool(true));
    mesh.set("int[]", "faceVertexCounts", Value::Ints(vec![3]));
    mesh.set("float3[]", "extent", Value::Float3s(Vec::new()));
    mesh.set("float2", "range", Value::Float2(Vec2::new(1e-7, 1e20)));
    mesh.set("float", "focalLength", Value::Float(0.1));
    mesh.set_by_vertex("texCoord2f[]", "primvars:st", Value::Float2s(vec![Vec2::X]));
    mesh.relate("material:binding", "/scene/m".into());
    mesh.place(DMat4::from_translation(glam::DVec3::new(0.1, 2.0, 3.0)));
    let mut root = Prim::new("Xform", "scene");
    root.children = vec![mesh, material];
    let metadata =
        vec![("defaultPrim", Value::token("scene")), ("metersPerUnit", Value::Double(1.0))];
    Stage { metadata, root }
}

const TEXT: &str = r##"#usda 1.0
(
    defaultPrim = "scene"
    metersPerUnit = 1
)

def Xform "scene"
{

    def Mesh "o" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        uniform bool doubleSided = 1
        int[] faceVertexCounts = [3]
        float3[] extent = []
        float2 range = (0.0000001, 100000000000000000000)
        float focalLength = 0.1
        texCoord2f[] primvars:st = [(1, 0)] (
            interpolation = "vertex"
        )
        rel material:binding = </scene/m>
        matrix4d xformOp:transform = ( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0.1, 2, 3, 1) )
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }

    def Material "m" (
        displayName = "a \"b\"\n\\ é"
    )
    {
        token outputs:surface.connect = </scene/m/surface.outputs:surface>

        def Shader "surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0.5, 0.1, 0)
            float4 inputs:scale = (2, 2, 2, 1)
            asset inputs:file = @@@./a b@c.exr@@@
            token outputs:surface
        }
    }
}
"##;

#[test]
fn text_is_that_of_the_format() {
    assert_eq!(String::from_utf8(text::bytes(&stage())).unwrap(), TEXT);
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

/// LZ4 by its definition, behind the number of chunks, of one sequence of literals.
fn unpacked(block: &[u8]) -> Vec<u8> {
    assert_eq!((block[0], block[1] & 15), (0, 0), "one chunk, no repetition");
    let (mut literals, mut at) = (usize::from(block[1] >> 4), 2);
    let mut is_longer = literals == 15;
    while is_longer {
        literals += usize::from(block[at]);
        is_longer = block[at] == 255;
        at += 1;
    }
    assert_eq!(at + literals, block.len());
    block[at..].to_vec()
}

/// The whole numbers of a block of differences at `at`, behind its size; `at` moves behind it.
fn numbers(bytes: &[u8], at: &mut usize, count: u64) -> Vec<i32> {
    let size = u64_at(bytes, *at) as usize;
    let coded = unpacked(&bytes[*at + 8..*at + 8 + size]);
    *at += 8 + size;
    let (mut number, mut next) = (0i32, 4 + (count as usize).div_ceil(4));
    let common = u32_at(&coded, 0).cast_signed();
    let one = |index: usize| {
        let code = coded[4 + index / 4] >> (2 * (index % 4)) & 3;
        let difference = match code {
            0 => common,
            1 => i32::from(coded[next].cast_signed()),
            2 => i32::from(i16::from_le_bytes([coded[next], coded[next + 1]])),
            _ => u32_at(&coded, next).cast_signed(),
        };
        next += [0, 1, 2, 4][usize::from(code)];
        number = number.wrapping_add(difference);
        number
    };
    (0..count as usize).map(one).collect()
}

/// For each path of a file its kind and its fields, read by the format's definition.
fn read(bytes: &[u8]) -> BTreeMap<String, (i32, BTreeMap<String, u64>)> {
    assert_eq!(&bytes[..11], b"PXR-USDC\0\x08\0");
    let contents = u64_at(bytes, 16) as usize;
    let tables: BTreeMap<&[u8], usize> = (0..u64_at(bytes, contents) as usize)
        .map(|row| contents + 8 + 32 * row)
        .map(|row| {
            (
                bytes[row..row + 16].split(|byte| *byte == 0).next().unwrap(),
                u64_at(bytes, row + 16) as usize,
            )
        })
        .collect();
    let table = |name: &str| tables[name.as_bytes()];
    let start = table("TOKENS");
    let text = unpacked(&bytes[start + 24..start + 24 + u64_at(bytes, start + 16) as usize]);
    assert_eq!(text.len() as u64, u64_at(bytes, start + 8));
    let tokens: Vec<String> = text
        .split_inclusive(|byte| *byte == 0)
        .map(|token| String::from_utf8(token[..token.len() - 1].to_vec()).unwrap())
        .collect();
    assert_eq!(tokens.len() as u64, u64_at(bytes, start));
    let columns = |name: &str, columns: usize| {
        let (start, mut at) = (table(name), table(name) + 8);
        let count = u64_at(bytes, start);
        (0..columns).map(|_| numbers(bytes, &mut at, count)).collect::<Vec<_>>()
    };
    let start = table("FIELDS");
    let mut at = start + 8;
    let names = numbers(bytes, &mut at, u64_at(bytes, start));
    let values = unpacked(&bytes[at + 8..at + 8 + u64_at(bytes, at) as usize]);
    let sets = columns("FIELDSETS", 1).remove(0);
    let mut at = table("PATHS") + 16;
    let count = u64_at(bytes, table("PATHS"));
    let [order, parts, jumps] = [(); 3].map(|()| numbers(bytes, &mut at, count));
    assert_eq!(order, (0..count as i32).collect::<Vec<_>>());
    let mut paths = vec![String::new(); order.len()];
    walk(0, "", &parts, &jumps, &tokens, &mut paths);
    let [of_path, of_set, kinds] = columns("SPECS", 3).try_into().unwrap();
    let spec = |index: usize| {
        let set = sets[of_set[index] as usize..].iter().take_while(|field| **field >= 0);
        let field = |field: &i32| {
            let field = *field as usize;
            (tokens[names[field] as usize].clone(), u64_at(&values, 8 * field))
        };
        (paths[of_path[index] as usize].clone(), (kinds[index], set.map(field).collect()))
    };
    (0..of_path.len()).map(spec).collect()
}

/// Names the node `index` below `parent`, all below it, and its siblings.
fn walk(
    index: usize,
    parent: &str,
    parts: &[i32],
    jumps: &[i32],
    tokens: &[String],
    paths: &mut [String],
) {
    let part = &tokens[parts[index].unsigned_abs() as usize];
    let path = match (index, parts[index] < 0) {
        (0, _) => String::new(),
        (_, true) => format!("{parent}.{part}"),
        (_, false) => format!("{parent}/{part}"),
    };
    paths[index] = path.clone();
    let jump = jumps[index];
    if jump == -1 || jump > 0 {
        walk(index + 1, &path, parts, jumps, tokens, paths);
    }
    if jump >= 0 {
        walk(index + jump.max(1) as usize, parent, parts, jumps, tokens, paths);
    }
}

#[test]
fn binary_has_every_path_with_its_fields() {
    let bytes = binary::bytes(&stage()).unwrap();
    let found = read(&bytes);
    let fields = |path: &str| &found[path].1;
    let kinds: Vec<i32> = ["", "/scene", "/scene/o.extent", "/scene/o.material:binding"]
        .map(|path| found[path].0)
        .to_vec();
    assert_eq!(kinds, [7, 6, 1, 8]);
    // The root, four prims and their properties.
    assert_eq!(found.len(), 1 + 4 + 9 + 1 + 5);
    let in_place = |bits: u32, kind: u64| 1 << 62 | kind << 48 | u64::from(bits);
    assert_eq!(fields("/scene/o.focalLength")["default"], in_place(0.1f32.to_bits(), 8));
    assert_eq!(fields("/scene/o.doubleSided")["default"], in_place(1, 1));
    assert_eq!(fields("/scene/o.doubleSided")["variability"], in_place(1, 44));
    assert_eq!(fields("/scene/o.extent")["default"], 1 << 63 | 24 << 48, "an empty array");
    let place = |path: &str, field: &str| (fields(path)[field] & ((1 << 48) - 1)) as usize;
    let matrix = place("/scene/o.xformOp:transform", "default");
    assert_eq!(f64::from_bits(u64_at(&bytes, matrix + 8 * 12)), 0.1);
    let counts = place("/scene/o.faceVertexCounts", "default");
    assert_eq!((u64_at(&bytes, counts), u32_at(&bytes, counts + 8)), (1, 3));
    // One explicit path: the index of the material's.
    let targets = place("/scene/o.material:binding", "targetPaths");
    assert_eq!((bytes[targets], u64_at(&bytes, targets + 1)), (3, 1));
    for (path, (_, fields)) in &found {
        let far = fields.values().filter(|value| **value & (1 << 62) == 0);
        assert!(far.clone().all(|value| value & 7 == 0), "{path}: values are aligned");
    }
}

#[test]
fn whole_numbers_survive_packing() {
    let many: Vec<i32> = (0..1000).map(|k: i32| k.wrapping_mul(k).wrapping_mul(97_531)).collect();
    for case in
        [vec![], vec![7], vec![-1; 9], vec![0, 1, 2, 300, -70_000, i32::MAX, i32::MIN], many]
    {
        let packed = packed::integers(case.iter().copied()).unwrap();
        assert_eq!(numbers(&packed, &mut 0, case.len() as u64), case);
    }
    for length in [0, 14, 15, 16, 269, 270, 271, 525, 1000] {
        let bytes: Vec<u8> = (0..length).map(|k| (k * 31) as u8).collect();
        assert_eq!(unpacked(&packed::block(&bytes).unwrap()), bytes, "{length} bytes");
    }
}

#[test]
fn packages_are_archives_of_aligned_files() {
    let names = (0..70).map(|length| format!("textures/{}", "a".repeat(length)));
    let files: Vec<(String, Vec<u8>)> =
        names.enumerate().map(|(k, name)| (name, vec![k as u8; 3 * k])).collect();
    let files = [vec![("scene.usdc".to_owned(), b"123456789".to_vec())], files].concat();
    let archive = package::bytes(&files).unwrap();
    let u16_at = |at: usize| usize::from(u16::from_le_bytes([archive[at], archive[at + 1]]));
    let end = archive.len() - 22;
    assert_eq!((&archive[end..end + 4], u16_at(end + 10)), (&b"PK\x05\x06"[..], 71));
    let mut entry = u32_at(&archive, end + 16) as usize;
    for (name, bytes) in &files {
        assert_eq!(&archive[entry..entry + 4], b"PK\x01\x02");
        let head = u32_at(&archive, entry + 42) as usize;
        assert_eq!((&archive[head..head + 4], u16_at(head + 8)), (&b"PK\x03\x04"[..], 0), "stored");
        assert_eq!(&archive[head + 30..][..name.len()], name.as_bytes());
        let start = head + 30 + u16_at(head + 26) + u16_at(head + 28);
        assert_eq!(start % 64, 0, "{name}");
        assert_eq!(&archive[start..start + u32_at(&archive, head + 18) as usize], &bytes[..]);
        entry += 46 + name.len();
    }
    assert_eq!(entry, end);
    // The check value of the checksum's definition.
    assert_eq!(u32_at(&archive, 14), 0xcbf4_3926);
}

#[test]
fn spots_send_the_light_that_they_sent() {
    for (inner, outer) in [(0.2f64, 0.6f64), (0.0, 0.5), (0.5, 0.55), (0.3, 1.5)] {
        let softness = lights::softness(inner, outer);
        let theirs = lights::sent(outer, |angle| lights::cone(angle, outer, softness));
        // In closed form: the square of a line in the cosine between both, all inside.
        let (full, zero) = (inner.cos(), outer.cos());
        let ours = std::f64::consts::TAU * (1.0 - full + (full - zero) / 3.0);
        assert!((theirs / ours - 1.0).abs() < 1e-4, "{inner} {outer}: {theirs} {ours}");
        assert!((0.0..=1.0).contains(&softness), "{softness}");
    }
}

#[test]
fn roughness_and_anisotropy_give_the_alphas_back() {
    for [smooth, rough] in [[0.1f32, 0.1], [0.02, 0.3], [0.25, 0.5]] {
        let roughness = openpbr::roughness([smooth, rough]);
        let across = smooth / rough;
        let along = roughness * roughness * (2.0 / (1.0 + across * across)).sqrt();
        assert!((along - rough).abs() < 1e-6 && (across * along - smooth).abs() < 1e-6);
    }
}

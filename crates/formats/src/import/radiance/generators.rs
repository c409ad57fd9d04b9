//! What Radiance's generators of simple bodies print: `genbox` and `genprism`.

use super::primitives::{Place, Primitive};
use glam::DVec3;
use unrender_scene::Warnings;

/// A surface of `material` without its place in the file.
fn surface(material: &str, kind: &str, id: String, reals: Vec<f64>) -> Primitive {
    Primitive {
        modifier: material.to_owned(),
        kind: kind.to_owned(),
        id,
        reals,
        ..Primitive::default()
    }
}

fn polygon(material: &str, id: String, corners: &[DVec3]) -> Primitive {
    surface(material, "polygon", id, corners.iter().flat_map(|c| c.to_array()).collect())
}

fn number(word: Option<&String>) -> Option<f64> {
    word.and_then(|word| word.parse::<f64>().ok()).filter(|v| (*v as f32).is_finite())
}

/// A box between the origin and its sizes, by `MATERIAL NAME X Y Z [-i] [-b BEVEL | -r ROUND]`.
pub(super) fn genbox(words: &[String]) -> Result<Vec<Primitive>, String> {
    const USE: &str = "is used as: genbox MATERIAL NAME X Y Z [-i] [-b BEVEL | -r RADIUS]";
    let [material, name, x, y, z, options @ ..] = words else { return Err(USE.into()) };
    let [Some(x), Some(y), Some(z)] = [x, y, z].map(|size| number(Some(size))) else {
        return Err(USE.into());
    };
    let (mut cut, mut is_round, mut inwards) = (0.0, false, false);
    let mut options = options.iter();
    while let Some(option) = options.next() {
        match option.as_str() {
            "-i" => inwards = true,
            "-b" | "-r" => {
                cut = number(options.next()).ok_or(USE)?;
                is_round |= option == "-r";
            }
            _ => return Err(format!("has \"{option}\"; it {USE}")),
        }
    }
    let body = Body { size: DVec3::new(x, y, z), cut: f64::max(cut, 0.0) };
    let mut found = Vec::new();
    for (number, mut places) in body.faces(is_round).into_iter().enumerate() {
        if inwards {
            places.reverse();
        }
        let corners: Vec<DVec3> = places.into_iter().map(|place| body.at(place)).collect();
        found.push(polygon(material, format!("{name}.{number}"), &corners));
    }
    if is_round && body.cut > 0.0 {
        for (kind, ends) in body.edges() {
            let mut reals: Vec<f64> =
                ends.iter().flat_map(|place| body.at(*place).to_array()).collect();
            reals.push(body.cut);
            found.push(surface(material, kind, format!("{name}.{}", found.len()), reals));
        }
    }
    Ok(found)
}

/// A corner of a box in steps along each axis: 0 at one end, 1 where the cut ends, 2 where the other
/// begins, 3 at the other end.
type Corner = [u8; 3];

struct Body {
    size: DVec3,
    /// How far its edges are cut.
    cut: f64,
}

impl Body {
    fn at(&self, corner: Corner) -> DVec3 {
        let along = |axis: usize| match corner[axis] {
            0 => 0.0,
            1 => self.cut,
            2 => self.size[axis] - self.cut,
            _ => self.size[axis],
        };
        DVec3::new(along(0), along(1), along(2))
    }

    /// The flat faces: six, and those of the cut edges and corners.
    fn faces(&self, is_round: bool) -> Vec<Vec<Corner>> {
        let [near, far] = if self.cut > 0.0 { [1, 2] } else { [0, 3] };
        let inner = |end: u8| if end == 0 { near } else { far };
        let mut faces = Vec::new();
        for (axis, end) in (0..3).flat_map(|axis| [(axis, 0), (axis, 3)]) {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let around = [[near, near], [far, near], [far, far], [near, far]];
            faces.push(around.map(|[a, b]| placed([(axis, end), (u, a), (v, b)])).to_vec());
        }
        if self.cut > 0.0 && !is_round {
            for (axis, a, b) in edges() {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let edge = |along: u8, out: bool| {
                    let [p, q] = if out { [a, inner(b)] } else { [inner(a), b] };
                    placed([(axis, along), (u, p), (v, q)])
                };
                faces.push(vec![
                    edge(near, true),
                    edge(far, true),
                    edge(far, false),
                    edge(near, false),
                ]);
            }
            for corner in corners() {
                let of = |axis: usize| {
                    [0, 1, 2].map(|k| if k == axis { corner[k] } else { inner(corner[k]) })
                };
                faces.push([0, 1, 2].map(of).to_vec());
            }
        }
        faces.iter_mut().for_each(|face| turn_outwards(face));
        faces
    }

    /// The round edges and corners.
    fn edges(&self) -> Vec<(&'static str, Vec<Corner>)> {
        let inner = |end: u8| if end == 0 { 1 } else { 2 };
        let tubes = edges().into_iter().map(|(axis, a, b)| {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let end = |along: u8| placed([(axis, along), (u, inner(a)), (v, inner(b))]);
            ("cylinder", vec![end(1), end(2)])
        });
        let balls = corners().map(|corner| ("sphere", vec![corner.map(inner)]));
        tubes.chain(balls).collect()
    }
}

fn placed(steps: [(usize, u8); 3]) -> Corner {
    let mut corner = [0; 3];
    steps.into_iter().for_each(|(axis, step)| corner[axis] = step);
    corner
}

/// The edges along each axis, by the ends of the next two axes at which they lie.
fn edges() -> Vec<(usize, u8, u8)> {
    let ends = [(0, 0), (3, 0), (3, 3), (0, 3)];
    (0..3).flat_map(|axis| ends.map(|(a, b)| (axis, a, b))).collect()
}

fn corners() -> impl Iterator<Item = Corner> {
    (0..8u8).map(|k| [k & 1, (k >> 1) & 1, k >> 2].map(|end| 3 * end))
}

/// Orders the corners of `face` counter-clockwise seen from outside a box of three steps.
fn turn_outwards(face: &mut [Corner]) {
    let points: Vec<DVec3> = face.iter().map(|c| DVec3::from_array(c.map(f64::from))).collect();
    let normal = (points[1] - points[0]).cross(points[2] - points[0]);
    if normal.dot(points[0] - DVec3::splat(1.5)) < 0.0 {
        face.reverse();
    }
}

/// A prism over a polygon in the xy plane, by
/// `MATERIAL NAME {N X1 Y1 .. XN YN | FILE} [-l X Y Z] [-r RADIUS] [-c] [-e]`; `from_file` are the
/// numbers of the file.
pub(super) fn genprism(
    words: &[String],
    from_file: Option<Vec<f64>>,
    place: &Place,
    warnings: &mut Warnings,
) -> Result<Vec<Primitive>, String> {
    const USE: &str =
        "is used as: genprism MATERIAL NAME {N X1 Y1 .. XN YN | FILE} [-l X Y Z] [-c] [-e]";
    let [material, name, count, rest @ ..] = words else { return Err(USE.into()) };
    let (flat, options) = match from_file {
        Some(numbers) => (numbers, rest),
        None => {
            let count = count.parse::<usize>().ok().and_then(|count| count.checked_mul(2));
            let count = count.filter(|count| *count <= rest.len()).ok_or(USE)?;
            let (corners, options) = rest.split_at(count);
            let corners: Option<Vec<f64>> = corners.iter().map(|word| number(Some(word))).collect();
            (corners.ok_or(USE)?, options)
        }
    };
    let bottom: Vec<DVec3> = flat.chunks_exact(2).map(|c| DVec3::new(c[0], c[1], 0.0)).collect();
    if bottom.len() < 3 {
        return Err("has fewer than three corners".into());
    }
    let (mut way, mut has_ends, mut is_closed) = (DVec3::Z, true, false);
    let mut options = options.iter();
    while let Some(option) = options.next() {
        let mut next = || number(options.next()).ok_or(USE);
        match option.as_str() {
            "-l" => way = DVec3::new(next()?, next()?, next()?),
            "-r" => {
                next()?;
                warnings
                    .push(format!("{place}: the edges of the prism \"{name}\" are not rounded"));
            }
            "-e" => has_ends = !has_ends,
            "-c" => is_closed = !is_closed,
            _ => return Err(format!("has \"{option}\"; it {USE}")),
        }
    }
    if way.z.abs() < 1e-6 {
        return Err("has a length that does not leave the xy plane".into());
    }
    let top: Vec<DVec3> = bottom.iter().map(|corner| *corner + way).collect();
    let mut found = Vec::new();
    if has_ends {
        let turned: Vec<DVec3> = top.iter().rev().copied().collect();
        found.push(polygon(material, format!("{name}.b"), &bottom));
        found.push(polygon(material, format!("{name}.t"), &turned));
    }
    // A closed polygon has its first corner as its last, and no side between them.
    for k in 0..bottom.len() - usize::from(is_closed) {
        let next = (k + 1) % bottom.len();
        let side = [bottom[k], top[k], top[next], bottom[next]];
        found.push(polygon(material, format!("{name}.{}", k + 1), &side));
    }
    Ok(found)
}

//! How far each object by itself is from its place in the photograph.
//!
//! The photograph's edge that is clearest near an edge of the model need not be that edge: where two
//! surfaces look alike it is faint or missing, and beside it lies a shadow or the edge of another object.
//! So an edge of the photograph says nothing here if the model has another edge at its place, and an
//! edge point of the model is in place if the photograph changes there, more clearly elsewhere or not.
//! An object that is elsewhere is so on both of its sides; a shadow lies on one.

use super::align::{Offset, median, vote};
use super::edges::Edgel;
use super::{REACH_PIXELS, Search};
use glam::Vec2;
use std::collections::HashMap;
use unrender_scene::Camera;

/// With edges along fewer pixels than this, or along half as many on one of its sides, an object says nothing of its own
/// place.
const FEW: usize = 20;
/// So large a share of its edge points must agree on a shift.
const MOST: f32 = 0.8;
/// Edges closer than this are one, pixels: the photograph's blur moves an edge by about half of it, and at
/// double, displacements that are noted (1.5) would pass for edges in place.
const SAME: f32 = 0.75;
/// ... if the directions across them differ by less than the angle of this cosine, 45 degrees.
const SAME_DIRECTION: f32 = 0.7;

/// For each of the first `objects`: how far its own edges are off under `camera`, pixels; zero where its
/// edge points are too few to tell.
pub(super) fn displacements(search: &Search<'_>, camera: &Camera, objects: u32) -> Vec<f32> {
    let edgels = search.edgels(camera);
    let of_model = OfModel::new(&edgels);
    let mut of_objects = vec![Vec::new(); objects as usize];
    let mut outlines = vec![Vec::new(); objects as usize];
    for edgel in &edgels {
        let Some(of_object) = of_objects.get_mut(edgel.object as usize) else { continue };
        outlines[edgel.object as usize].push(edgel.at);
        let Some(distance) = search.picture.offset(edgel, REACH_PIXELS[0]) else { continue };
        let offset = Offset { edgel: *edgel, distance };
        if distance.abs() <= SAME {
            of_object.push(offset);
        } else if search.picture.has_edge(edgel, SAME) {
            of_object.push(Offset { distance: 0.0, ..offset });
        } else if !of_model.explains(&offset) {
            of_object.push(offset);
        }
    }
    let few = FEW * search.finer;
    of_objects.iter().zip(&outlines).map(|(own, outline)| displacement(own, outline, few)).collect()
}

/// How far these edge points of the object with this `outline` are off, if most of them agree on it, on both of its sides.
fn displacement(own: &[Offset], outline: &[Vec2], few: usize) -> f32 {
    if own.len() < few {
        return 0.0;
    }
    let (shift, share) = vote(own, REACH_PIXELS[0]);
    let along = |point: &Vec2| point.dot(shift);
    let [low, high] =
        outline.iter().map(along).fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        });
    let (first, second): (Vec<&Offset>, Vec<&Offset>) = own
        .iter()
        .filter(|offset| offset.distance.abs() > SAME)
        .partition(|offset| along(&offset.edgel.at) < 0.5 * (low + high));
    let both_sides = first.len().min(second.len()) >= few / 2;
    let across = median(own.iter().map(|o| o.edgel.across.dot(shift).abs()));
    if share > MOST && both_sides { across.unwrap_or(0.0) } else { 0.0 }
}

/// The model's edge points, by the squares of the picture that they lie in.
struct OfModel<'e>(HashMap<[i32; 2], Vec<&'e Edgel>>);

impl<'e> OfModel<'e> {
    fn new(edgels: &'e [Edgel]) -> Self {
        let mut cells: HashMap<[i32; 2], Vec<&Edgel>> = HashMap::new();
        for edgel in edgels {
            cells.entry(cell(edgel.at)).or_default().push(edgel);
        }
        Self(cells)
    }

    /// Whether the edge that the photograph has beside this one is another of the model's.
    fn explains(&self, offset: &Offset) -> bool {
        let Offset { edgel, distance } = offset;
        let there = edgel.at + edgel.across * *distance;
        let [x, y] = cell(there);
        let near = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [x + dx, y + dy]));
        near.filter_map(|cell| self.0.get(&cell)).flatten().any(|other| {
            let apart = other.across.dot(there - other.at).abs();
            let alike = other.across.dot(edgel.across).abs() > SAME_DIRECTION;
            // Further along the same edge, it is this one's own.
            alike && apart <= SAME && other.across.dot(edgel.at - other.at).abs() > SAME
        })
    }
}

/// The square of one pixel that a point lies in.
fn cell(at: Vec2) -> [i32; 2] {
    [at.x.floor() as i32, at.y.floor() as i32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn edgel(x: f32, y: f32, object: u32) -> Edgel {
        Edgel { at: Vec2::new(x, y), across: Vec2::X, point: Vec3::ZERO, object }
    }

    #[test]
    fn the_photographs_edge_is_that_of_the_model_which_lies_there() {
        let edgels = [edgel(10.0, 20.0, 0), edgel(10.0, 21.0, 0), edgel(13.0, 20.4, 1)];
        let of_model = OfModel::new(&edgels);
        let explains = |distance: f32| of_model.explains(&Offset { edgel: edgels[0], distance });
        assert!(explains(3.0) && explains(2.5));
        assert!(!explains(-3.0) && !explains(1.5) && !explains(0.3));
    }

    #[test]
    fn edges_that_agree_on_a_shift_on_both_sides_are_off_by_it() {
        let offsets = |x: f32, distance: f32| {
            (0..30).map(move |y| Offset { edgel: edgel(x, y as f32, 0), distance })
        };
        let off = |own: &[Offset]| {
            // The object reaches from 10 to 40.
            displacement(own, &[Vec2::new(10.0, 0.0), Vec2::new(40.0, 29.0)], 20)
        };
        let both: Vec<Offset> = offsets(10.0, 2.5).chain(offsets(40.0, 2.5)).collect();
        // Of the shifts that fit equally well the nearest is taken, and they fit to 0.75.
        assert!((off(&both) - 2.5).abs() < 0.75);
        assert_eq!(off(&both[25..35]), 0.0, "few edge points");
        let disagreeing: Vec<Offset> = offsets(10.0, 2.5).chain(offsets(40.0, 0.0)).collect();
        assert_eq!(off(&disagreeing), 0.0);
        let shadow: Vec<Offset> = offsets(40.0, 2.5).collect();
        assert_eq!(off(&shadow), 0.0, "one side alone may be a shadow");
    }
}

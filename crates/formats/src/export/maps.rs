//! Pictures of normals and holes for programs that have words for them.

use glam::{Vec2, Vec3};
use unrender_scene::{Coverage, Image, Mapped, Mesh, NormalMap, Rgb, Scene, Warnings};

/// Texels of a stencil for one of the coverage, across and down. Where coverage is interpolated the edge of a hole runs
/// between texels: this puts it an eighth of one off at most. Half of it shows steps, double of it takes four times the
/// space (neither tried).
const FINER: usize = 4;

/// The longest side of a stencil that is finer than its coverage, texels; as one byte each it takes 64 MiB to make.
/// Double of it would take 256 MiB, half of it would make the edges of large pictures coarser.
const LONGEST: usize = 8192;

/// What is added to the identifier of a material for objects upon which pictures lie mirrored.
const MIRRORED: &str = "-mirrored";

/// What is added to the identifier of a group for those of its objects that are `mirrored`.
pub(super) fn suffix(mirrored: bool) -> &'static str {
    if mirrored { MIRRORED } else { "" }
}

/// Where `coverage` has holes, 0 there and 1 elsewhere, in texels that are not to be interpolated. Programs take
/// coverage as a probability: interpolated, or as it is, it would make edges that are half there.
pub(super) fn stencil(coverage: &Coverage) -> Mapped<f32> {
    let Mapped { image, wrap_u, wrap_v } = &coverage.alpha;
    let longest = image.width().max(image.height()).max(1);
    let finer = (LONGEST / longest).clamp(1, FINER);
    let (width, height) = (finer * image.width(), finer * image.height());
    let size = Vec2::new(width as f32, height as f32);
    let image = Image::from_fn(width, height, |x, y| {
        let uv = (Vec2::new(x as f32, y as f32) + 0.5) / size;
        if coverage.is_hole(uv) { 0.0 } else { 1.0 }
    });
    Mapped { image, wrap_u: *wrap_u, wrap_v: *wrap_v }
}

/// The normals as colours, where 0 to 1 stand for -1 to 1; on a `mirrored` mesh, for programs that take the picture's
/// upward direction to be `normal x tangent` everywhere.
pub(super) fn colors(map: &NormalMap, mirrored: bool) -> Mapped<Rgb> {
    let sign = if mirrored { Vec3::new(1.0, -1.0, 1.0) } else { Vec3::ONE };
    let Mapped { image, wrap_u, wrap_v } = &map.normals;
    let image = image.map(|normal| 0.5 * sign * *normal + 0.5);
    Mapped { image, wrap_u: *wrap_u, wrap_v: *wrap_v }
}

/// Whether `mesh` has a normal map that lies mirrored upon most of its triangles.
pub(super) fn is_mirrored(mesh: &Mesh) -> bool {
    if mesh.detail.normals.is_none() || mesh.uvs.is_empty() {
        return false;
    }
    let mirrored = (0..mesh.triangles.len()).filter(|index| is_turned_over(mesh, *index)).count();
    2 * mirrored > mesh.triangles.len()
}

/// Whether one of the objects of group `index` is one of those ([`is_mirrored`]).
pub(super) fn has_mirrored(scene: &Scene, index: usize) -> bool {
    let mut own = scene.objects.iter().filter(|object| object.group == index);
    own.any(|object| is_mirrored(&object.mesh))
}

/// Warns of objects on which a picture lies mirrored here and not there.
pub(super) fn warn_of_halves<'a>(
    meshes: impl Iterator<Item = (&'a str, &'a Mesh)>,
    program: &str,
    warnings: &mut Warnings,
) {
    let is_both = |mesh: &Mesh| {
        let mirrored = (0..mesh.triangles.len()).filter(|index| is_turned_over(mesh, *index));
        ![0, mesh.triangles.len()].contains(&mirrored.count())
    };
    let has_normals = |mesh: &Mesh| mesh.detail.normals.is_some() && !mesh.uvs.is_empty();
    let mut halves = meshes.filter(|(_, mesh)| has_normals(mesh) && is_both(mesh));
    if let Some((name, _)) = halves.next() {
        let more = match halves.count() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        warnings.push(format!(
            "object \"{name}\"{more}: its normal map lies mirrored on a part of it, where {program} turns bumps upside \
             down; make that an object of its own"
        ));
    }
}

/// Whether the picture lies mirrored upon triangle `index`.
fn is_turned_over(mesh: &Mesh, index: usize) -> bool {
    let corners = mesh.triangles[index].map(|i| i as usize);
    if !mesh.tangents.is_empty() {
        return corners.iter().map(|&i| mesh.tangents[i].w).sum::<f32>() < 0.0;
    }
    let [a, b, c] = corners.map(|i| mesh.uvs[i]);
    // v grows downwards.
    (b - a).perp_dot(c - a) > 0.0
}

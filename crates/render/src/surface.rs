//! Surface interactions: a point with its shading frame, group and texture coordinate.

use glam::{Vec2, Vec3};

/// A point on a surface, with normals on the side from which a ray arrived.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// The point in world space, metres.
    pub point: Vec3,
    /// The triangle's index in the scene.
    pub triangle: u32,
    /// The object's index in the scene.
    pub object: u32,
    /// The group's index in the scene.
    pub group: u32,
    /// Whether the ray arrived on the front (counter-clockwise) side.
    pub front: bool,
    /// Unit normal of the triangle on the viewer's side.
    pub geometric_normal: Vec3,
    /// How far off the triangle rays that leave it start, metres ([`crate::accel::clearance`]).
    pub clearance: f32,
    /// The shading frame.
    pub frame: Frame,
    /// `TEXCOORD_0`; zero where there is none.
    pub uv: Vec2,
}

impl Surface {
    /// Where rays that leave it start: on the viewer's side of the triangle, just far enough not to meet it again.
    #[inline]
    pub fn start(&self) -> Vec3 {
        self.point + self.clearance * self.geometric_normal
    }

    /// True if `wi`, in world space, lies in the upper hemisphere of both the geometric and the
    /// shading normal.
    pub fn is_above(&self, wi: Vec3) -> bool {
        wi.dot(self.geometric_normal) > 0.0 && wi.dot(self.frame.normal) > 0.0
    }
}

/// The cosine at which a surface is seen whose shading normal faces away: a degree above the surface, where lobes are
/// still finite. Half and double change a diffuse surface by nothing, and a lobe as half a degree of grazing does.
const GRAZING: f32 = 0.02;

/// The tangent frame at a surface: z the shading normal on the viewer's side, x the surface's
/// tangent, y such that angles from x to y are counter-clockwise *seen from the front*.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Unit tangent, from which the angle of anisotropy is measured.
    pub tangent: Vec3,
    /// Unit vector orthogonal to tangent and normal.
    pub bitangent: Vec3,
    /// Unit shading normal.
    pub normal: Vec3,
}

impl Frame {
    /// A frame from the shading normal of the front, a tangent that need not be orthogonal to it,
    /// and whether the ray arrived on the front.
    pub fn new(front_normal: Vec3, tangent: Vec3, front: bool) -> Self {
        let across = front_normal.cross(tangent).try_normalize();
        let bitangent = across.unwrap_or_else(|| front_normal.any_orthonormal_vector());
        let normal = if front { front_normal } else { -front_normal };
        Self { tangent: bitangent.cross(front_normal), bitangent, normal }
    }

    /// The same where the tangent is a unit vector orthogonal to the normal.
    #[inline]
    pub(crate) fn orthonormal(front_normal: Vec3, tangent: Vec3, front: bool) -> Self {
        let normal = if front { front_normal } else { -front_normal };
        Self { tangent, bitangent: front_normal.cross(tangent), normal }
    }

    /// A direction in world space as one in this frame.
    #[inline]
    pub fn local_from_world(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.normal))
    }

    /// The direction towards the viewer in this frame, on the front of the shading normal. Where a surface is shaded
    /// smooth over an edge, the shading normal may face away from who sees it. The direction is then raised to
    /// [`GRAZING`]: what is seen is not black, and a diffuse surface is as bright as from any other side.
    #[inline]
    pub(crate) fn local_from_viewer(&self, wo: Vec3) -> Vec3 {
        let local = self.local_from_world(wo);
        if local.z > 0.0 {
            return local;
        }
        let along = local.truncate().normalize_or(Vec2::X) * (1.0 - GRAZING * GRAZING).sqrt();
        along.extend(GRAZING)
    }

    /// A direction in this frame as one in world space.
    #[inline]
    pub fn world_from_local(&self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }

    /// The anisotropy frame: this one turned about the normal of the front by the angle of this sine and cosine.
    #[inline]
    pub(crate) fn turned(&self, (sin, cos): (f32, f32)) -> Self {
        Self {
            tangent: self.tangent * cos + self.bitangent * sin,
            bitangent: self.bitangent * cos - self.tangent * sin,
            normal: self.normal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_of_anisotropy_is_counter_clockwise_from_the_front_on_both_sides() {
        for front in [true, false] {
            let frame = Frame::new(Vec3::Z, Vec3::X, front);
            let rotated = frame.turned(0.3f32.sin_cos());
            assert!((rotated.tangent - Vec3::new(0.3f32.cos(), 0.3f32.sin(), 0.0)).length() < 1e-6);
            assert_eq!(frame.normal.z > 0.0, front);
        }
    }
}

//! Surface interactions: a point with its shading frame, group and texture coordinate.

use glam::{Vec2, Vec3};

/// The object and group of pixels whose ray hits no surface, and the group of glass.
pub const NOTHING: u32 = u32::MAX;

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
    /// Unit vector back along the ray that arrived.
    pub to_viewer: Vec3,
    /// Unit shading normal of the mesh on the viewer's side: that of the frame but for a normal map.
    pub mesh_normal: Vec3,
    /// Whether the bumps of its normal map shade themselves.
    pub shades_itself: bool,
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

    /// The frame of a lobe. Where shading normals lean so far from the triangle that what they reflect towards the viewer
    /// lies below it, they are turned back until it lies [`GRAZING`] above: else the rims of smooth things and the
    /// slopes of normal maps were black.
    ///
    /// In the plane of both normals, with the angles from that of the triangle `phi` of the shading normal and `psi` of
    /// the viewer, what is reflected rises `r cos(2 phi - psi)` above the triangle, where `r` is the length of the viewer's
    /// direction in that plane.
    #[inline]
    pub(crate) fn lobe_frame(&self) -> Frame {
        let (normal, geometric, viewer) =
            (self.frame.normal, self.geometric_normal, self.to_viewer);
        let rises = |n: Vec3| 2.0 * viewer.dot(n) * n.dot(geometric) - viewer.dot(geometric);
        // What a flat triangle reflects rises as far as the viewer.
        let least = GRAZING.min(0.5 * viewer.dot(geometric));
        if rises(normal) >= least {
            return self.frame;
        }
        let Some(along) = normal.reject_from(geometric).try_normalize() else { return self.frame };
        let (x, z) = (viewer.dot(along), viewer.dot(geometric));
        let turned = 0.5 * (x.atan2(z) + (least / x.hypot(z)).acos());
        let normal = along * turned.sin() + geometric * turned.cos();
        self.frame.about(normal)
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

    /// This frame with another normal.
    fn about(&self, normal: Vec3) -> Self {
        let tangent = self.tangent.reject_from(normal).try_normalize();
        let tangent = tangent.unwrap_or_else(|| normal.any_orthonormal_vector());
        // As the former bitangent, on either side.
        let bitangent = normal.cross(tangent);
        let side = 1f32.copysign(bitangent.dot(self.bitangent));
        Self { tangent, bitangent: side * bitangent, normal }
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
    fn what_a_lobe_reflects_rises_above_the_triangle() {
        let tilted = |degrees: f32| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            Vec3::new(sin, 0.0, cos)
        };
        for viewer in [-89.9f32, -80.0, -45.0, 0.0, 45.0, 80.0] {
            let viewer = (tilted(viewer) + 0.3 * Vec3::Y).normalize();
            for normal in [-89.0f32, -60.0, -10.0, 0.0, 10.0, 60.0, 89.0] {
                let frame = Frame::new(tilted(normal), Vec3::Y, true);
                let surface = Surface {
                    point: Vec3::ZERO,
                    triangle: 0,
                    object: 0,
                    group: 0,
                    front: true,
                    geometric_normal: Vec3::Z,
                    clearance: 0.0,
                    frame,
                    uv: Vec2::ZERO,
                    to_viewer: viewer,
                    mesh_normal: frame.normal,
                    shades_itself: false,
                };
                let found = surface.lobe_frame();
                let reflected = 2.0 * viewer.dot(found.normal) * found.normal - viewer;
                let least = GRAZING.min(0.5 * viewer.z);
                assert!(reflected.z > least - 1e-5, "{viewer} {normal}: {reflected}");
                let kept = 2.0 * viewer.dot(frame.normal) * frame.normal - viewer;
                assert_eq!(kept.z >= least, found.normal == frame.normal);
                let across = found.tangent.cross(found.bitangent).dot(found.normal);
                assert!((across - 1.0).abs() < 1e-5 && found.tangent.y > 0.99);
            }
        }
    }

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

//! What a ray has met: a point with its frame, its group and its texture coordinate.

use glam::{Vec2, Vec3};

/// A point on a surface, seen from the side of `wo`.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// The point in world space, metres.
    pub point: Vec3,
    /// The triangle, counted over the whole scene.
    pub triangle: u32,
    /// The object's index in the scene.
    pub object: u32,
    /// The group's index in the scene.
    pub group: u32,
    /// Whether the front (counter-clockwise) side is seen.
    pub front: bool,
    /// Unit normal of the triangle on the viewer's side.
    pub geometric_normal: Vec3,
    /// The shading frame.
    pub frame: Frame,
    /// `TEXCOORD_0`; zero where there is none.
    pub uv: Vec2,
}

impl Surface {
    /// True if `wi`, in world space, leaves the surface on the viewer's side: by the triangle and
    /// by the shading normal.
    pub fn is_above(&self, wi: Vec3) -> bool {
        wi.dot(self.geometric_normal) > 0.0 && wi.dot(self.frame.normal) > 0.0
    }
}

/// The tangent frame at a surface: z the shading normal on the viewer's side, x the surface's
/// tangent, y such that angles from x to y count counter-clockwise *seen from the front*.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Unit tangent, the zero of the brushed angle.
    pub tangent: Vec3,
    /// Unit vector at a right angle to tangent and normal.
    pub bitangent: Vec3,
    /// Unit shading normal.
    pub normal: Vec3,
}

impl Frame {
    /// A frame from the shading normal of the front, a tangent that need not be orthogonal to it,
    /// and whether the front is seen.
    pub fn new(front_normal: Vec3, tangent: Vec3, front: bool) -> Self {
        let across = front_normal.cross(tangent).try_normalize();
        let bitangent = across.unwrap_or_else(|| front_normal.any_orthonormal_vector());
        let normal = if front { front_normal } else { -front_normal };
        Self { tangent: bitangent.cross(front_normal), bitangent, normal }
    }

    /// A world direction in the tangent frame.
    #[inline]
    pub fn local_from_world(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.normal))
    }

    /// A direction of the tangent frame in the world.
    #[inline]
    pub fn world_from_local(&self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }

    /// This frame turned by `theta` about the normal of the front: x becomes the brushed direction.
    #[inline]
    pub fn brushed(&self, theta_rad: f32) -> Self {
        if theta_rad == 0.0 {
            return *self;
        }
        let (sin, cos) = theta_rad.sin_cos();
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
    fn the_brushed_angle_counts_counter_clockwise_from_the_front_on_both_sides() {
        for front in [true, false] {
            let frame = Frame::new(Vec3::Z, Vec3::X, front);
            let brushed = frame.brushed(0.3);
            assert!((brushed.tangent - Vec3::new(0.3f32.cos(), 0.3f32.sin(), 0.0)).length() < 1e-6);
            assert_eq!(frame.normal.z > 0.0, front);
        }
    }
}

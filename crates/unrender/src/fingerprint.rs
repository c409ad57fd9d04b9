//! A digest of all data of a scene, to compare whether two pieces of work are of the same scene.
//!
//! The digest is of the scene in the wire format of postcard (version 1, which is documented and
//! stable): every number by its bits, little-endian, every list after its length, so that two
//! scenes with the same digest are equal. A field that is added later is included at once.

use serde::Serialize;
use sha2::{Digest, Sha256};

/// The first half of SHA-256 over the bytes of `value`, in hexadecimal digits.
pub(crate) fn fingerprint(value: &impl Serialize) -> String {
    // Writing to a digest cannot fail, and plain data without maps of unknown size can always be
    // serialised.
    let digest = postcard::to_io(value, Sha256::new()).unwrap_or_default().finalize();
    digest[..16].iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::{Camera, Group, Material, Rgb, Scene};

    fn scene(rho: f32) -> Scene {
        let material = Material::diffuse(Rgb::splat(rho));
        let wall = Group { name: "wall".into(), material, emission: Rgb::ZERO };
        Scene { groups: vec![wall], ..Scene::default() }
    }

    #[test]
    fn a_last_bit_makes_another_scene() {
        let of = |rho: f32| fingerprint(&scene(rho));
        assert_eq!(of(0.5), of(0.5));
        assert_ne!(of(0.5), of(0.5f32.next_up()));
        assert_ne!(of(0.0), of(-0.0));
        assert_ne!(of(f32::NAN), of(-f32::NAN));
        assert_eq!(of(0.5).len(), 32);
    }

    #[test]
    fn the_digest_is_of_bytes_that_are_defined_and_stay() {
        // Objects, groups (one, of a name of four bytes), the three numbers of rho_d and rho_s each,
        // roughness and direction, no texture, the emission; lights, environment, cameras, lobe.
        let mut bytes = vec![0, 1, 4];
        bytes.extend(b"wall");
        [0.5f32; 3].iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend([0; 12 + 12]);
        bytes.push(0);
        bytes.extend([0; 12]);
        bytes.extend([0, 0, 0]);
        let written = postcard::to_stdvec(&scene(0.5)).unwrap();
        assert_eq!(written[..bytes.len()], bytes);
        let digest = Sha256::digest(&written);
        let digits: String = digest[..16].iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(fingerprint(&scene(0.5)), digits);
    }

    #[test]
    fn text_cannot_pass_for_structure() {
        // In a text form, a name could contain what looks like the next field.
        let named = |names: [&str; 2]| {
            let camera = |name: &&str| Camera {
                name: (*name).to_owned(),
                ..Camera::look_at("", glam::Vec3::Z, glam::Vec3::ZERO, glam::Vec3::Y, 1.0)
            };
            fingerprint(&names.iter().map(camera).collect::<Vec<_>>())
        };
        assert_ne!(named(["ab", "c"]), named(["a", "bc"]));
    }
}

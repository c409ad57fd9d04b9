//! Serialisation of shared pointers, as their contents, and of rasters. A raster is read back only if it has as many
//! pixels as it says.

use crate::Image;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::sync::Arc;

/// Writes the contents of a pointer.
pub(crate) fn pointee<T: Serialize, S: Serializer>(
    value: &Arc<T>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    value.as_ref().serialize(serializer)
}

/// The contents of a pointer, if there is one.
pub(crate) mod shared {
    use super::{Arc, Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<T: Serialize, S: Serializer>(
        value: &Option<Arc<T>>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        value.as_deref().serialize(serializer)
    }

    pub(crate) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<Arc<T>>, D::Error> {
        Ok(Option::<T>::deserialize(deserializer)?.map(Arc::new))
    }
}

/// An [`Image`] before its size was checked.
#[derive(Deserialize)]
struct Raster<T> {
    width: usize,
    height: usize,
    pixels: Vec<T>,
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Image<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Raster { width, height, pixels } = Raster::deserialize(deserializer)?;
        if width.checked_mul(height) != Some(pixels.len()) {
            return Err(de::Error::custom("a raster does not have as many pixels as it says"));
        }
        Ok(Self::new(width, height, pixels))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, Rgb, Texture, Wrap};

    #[test]
    fn materials_read_back_to_the_bit_and_false_sizes_are_refused() {
        let odd = [f32::MIN_POSITIVE / 3.0, -0.0, f32::INFINITY, 0.1, 1.0 / 3.0, f32::NAN];
        let image = Image::from_fn(3, 2, |x, y| Rgb::splat(odd[3 * y + x]));
        let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::ClampToEdge };
        let material =
            Material { texture: Some(Arc::new(texture)), ..Material::diffuse(Rgb::splat(0.1)) };
        let bytes = postcard::to_stdvec(&material).unwrap();
        let read: Material = postcard::from_bytes(&bytes).unwrap();
        let bits = |material: &Material| -> Vec<u32> {
            let texels = material.texture.as_ref().unwrap().image.pixels().iter();
            texels.flat_map(|t| t.to_array()).map(f32::to_bits).collect()
        };
        assert_eq!(bits(&read), bits(&material));
        assert_eq!(postcard::to_stdvec(&read).unwrap(), bytes);
        let raster = postcard::to_stdvec(&(4usize, 2usize, vec![1u8; 6])).unwrap();
        assert!(postcard::from_bytes::<Image<u8>>(&raster).is_err());
    }
}

//! Loads Embree 4 [Wald et al. 2014] from its shared library: the few functions of its C interface
//! for one ray at a time.
#![allow(unsafe_code)]

use super::kernel::Kernel;
use glam::Vec3;
use libloading::Library;
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::path::Path;
use std::{fmt, ptr, slice};
use unrender::render::accel::Ray;

const TRIANGLES: c_int = 0;
const INDEX_BUFFER: c_int = 0;
const VERTEX_BUFFER: c_int = 1;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
const MEDIUM_QUALITY: c_int = 1;
const NO_FLAGS: c_int = 0;
const ROBUST: c_int = 1 << 2;
const VERSION: c_int = 0;
const INVALID: u32 = u32::MAX;

/// The mode of Embree's trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Its default; rays may pass through between triangles.
    Fast,
    /// `RTC_SCENE_FLAG_ROBUST`.
    Robust,
}

impl Mode {
    pub(crate) const ALL: [Self; 2] = [Self::Fast, Self::Robust];
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if *self == Self::Fast { "fast" } else { "robust" })
    }
}

/// `RTCRay`.
#[repr(C, align(16))]
struct RtcRay {
    origin: [f32; 3],
    t_near: f32,
    direction: [f32; 3],
    time: f32,
    t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

/// `RTCHit`, and room for the fields that some builds of the library append to it.
#[repr(C, align(16))]
struct RtcHit {
    normal: [f32; 3],
    u: f32,
    v: f32,
    triangle: u32,
    geometry: u32,
    instance: [u32; 5],
}

/// `RTCRayHit`.
#[repr(C, align(16))]
struct RtcRayHit {
    ray: RtcRay,
    hit: RtcHit,
}

type Handle = *mut c_void;
type Error = unsafe extern "C" fn(Handle) -> c_int;
type Act = unsafe extern "C" fn(Handle);
type Set = unsafe extern "C" fn(Handle, c_int);

/// The functions, as `rtcore.h` declares them.
struct Functions {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    device_property: unsafe extern "C" fn(Handle, c_int) -> isize,
    device_error: Error,
    release_device: Act,
    new_scene: unsafe extern "C" fn(Handle) -> Handle,
    set_scene_flags: Set,
    set_scene_quality: Set,
    commit_scene: Act,
    release_scene: Act,
    new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle,
    new_buffer: unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void,
    commit_geometry: Act,
    attach_geometry: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    release_geometry: Act,
    intersect: unsafe extern "C" fn(Handle, *mut RtcRayHit, *mut c_void),
    occluded: unsafe extern "C" fn(Handle, *mut RtcRay, *mut c_void),
}

/// The library with its device.
pub(crate) struct Embree {
    functions: Functions,
    device: Handle,
    /// Must outlive all of the above.
    _library: Library,
}

impl Embree {
    /// Loads the library at `path`.
    ///
    /// # Errors
    /// If it cannot be loaded, lacks a function, or makes no device.
    pub(crate) fn load(path: &Path) -> Result<Self, String> {
        let problem = |error: libloading::Error| format!("{}: {error}", path.display());
        // SAFETY: on loading, Embree and its TBB only set up their own memory, which they release
        // on unloading.
        let library = unsafe { Library::new(path) }.map_err(problem)?;
        let functions = functions(&library).map_err(problem)?;
        // SAFETY: a null pointer means the default configuration.
        let device = unsafe { (functions.new_device)(ptr::null()) };
        if device.is_null() {
            // SAFETY: a null device means the error of the last attempt to make one.
            let error = unsafe { (functions.device_error)(device) };
            return Err(format!("Embree makes no device: its error {error}"));
        }
        Ok(Self { functions, device, _library: library })
    }

    /// The version in its makers' form.
    pub(crate) fn version(&self) -> String {
        // SAFETY: the device lives as long as `self`.
        let number = unsafe { (self.functions.device_property)(self.device, VERSION) };
        format!("{}.{}.{}", number / 10_000, number / 100 % 100, number % 100)
    }

    /// Makes the tree over `triangles`, on all cores.
    pub(crate) fn build(&self, triangles: &[[Vec3; 3]], mode: Mode) -> EmbreeScene<'_> {
        let f = &self.functions;
        let flags = if mode == Mode::Robust { ROBUST } else { NO_FLAGS };
        // SAFETY: device, scene and geometry live until they are released: the geometry here, while
        // the scene keeps a reference to it, the scene with the value returned, the device after
        // that. The buffers that Embree returns have the requested sizes and are aligned to 16
        // bytes; they are filled before the geometry is committed.
        let scene = unsafe {
            let scene = (f.new_scene)(self.device);
            (f.set_scene_flags)(scene, flags);
            (f.set_scene_quality)(scene, MEDIUM_QUALITY);
            let geometry = (f.new_geometry)(self.device, TRIANGLES);
            let count = triangles.len();
            let positions = (f.new_buffer)(geometry, VERTEX_BUFFER, 0, FLOAT3, 12, 3 * count);
            let indices = (f.new_buffer)(geometry, INDEX_BUFFER, 0, UINT3, 12, count);
            let positions = slice::from_raw_parts_mut(positions.cast::<[Vec3; 3]>(), count);
            positions.copy_from_slice(triangles);
            let indices = slice::from_raw_parts_mut(indices.cast::<[u32; 3]>(), count);
            for (i, triangle) in (0u32..).step_by(3).zip(indices) {
                *triangle = [i, i + 1, i + 2];
            }
            (f.commit_geometry)(geometry);
            (f.attach_geometry)(scene, geometry);
            (f.release_geometry)(geometry);
            (f.commit_scene)(scene);
            scene
        };
        EmbreeScene { embree: self, scene }
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: its scenes borrow `self`, so they were dropped before.
        unsafe { (self.functions.release_device)(self.device) };
    }
}

fn functions(library: &Library) -> Result<Functions, libloading::Error> {
    // SAFETY: the types of the fields are those of the functions in Embree's header `rtcore.h`;
    // they are called only while the library is loaded.
    unsafe {
        Ok(Functions {
            new_device: *library.get(b"rtcNewDevice\0")?,
            device_property: *library.get(b"rtcGetDeviceProperty\0")?,
            device_error: *library.get(b"rtcGetDeviceError\0")?,
            release_device: *library.get(b"rtcReleaseDevice\0")?,
            new_scene: *library.get(b"rtcNewScene\0")?,
            set_scene_flags: *library.get(b"rtcSetSceneFlags\0")?,
            set_scene_quality: *library.get(b"rtcSetSceneBuildQuality\0")?,
            commit_scene: *library.get(b"rtcCommitScene\0")?,
            release_scene: *library.get(b"rtcReleaseScene\0")?,
            new_geometry: *library.get(b"rtcNewGeometry\0")?,
            new_buffer: *library.get(b"rtcSetNewGeometryBuffer\0")?,
            commit_geometry: *library.get(b"rtcCommitGeometry\0")?,
            attach_geometry: *library.get(b"rtcAttachGeometry\0")?,
            release_geometry: *library.get(b"rtcReleaseGeometry\0")?,
            intersect: *library.get(b"rtcIntersect1\0")?,
            occluded: *library.get(b"rtcOccluded1\0")?,
        })
    }
}

/// A tree of Embree's.
pub(crate) struct EmbreeScene<'a> {
    embree: &'a Embree,
    scene: Handle,
}

// SAFETY: any number of threads may use a committed scene at once, and nothing changes it.
unsafe impl Sync for EmbreeScene<'_> {}

impl Drop for EmbreeScene<'_> {
    fn drop(&mut self) {
        // SAFETY: the scene is released once; the library is still loaded, since `embree` is.
        unsafe { (self.embree.functions.release_scene)(self.scene) };
    }
}

impl RtcRay {
    fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.to_array(),
            t_near: 0.0,
            direction: ray.direction.to_array(),
            time: 0.0,
            t_far: ray.t_max,
            mask: u32::MAX,
            id: 0,
            flags: 0,
        }
    }
}

impl RtcHit {
    const NONE: Self = Self {
        normal: [0.0; 3],
        u: 0.0,
        v: 0.0,
        triangle: INVALID,
        geometry: INVALID,
        instance: [INVALID; 5],
    };
}

impl Kernel for EmbreeScene<'_> {
    fn closest(&self, rays: &[Ray], distances: &mut [f32]) {
        for (ray, distance) in rays.iter().zip(distances) {
            let mut both = RtcRayHit { ray: RtcRay::new(ray), hit: RtcHit::NONE };
            // SAFETY: the scene is committed, `both` is laid out and aligned as in the header, and
            // null means the default arguments.
            unsafe {
                (self.embree.functions.intersect)(self.scene, &raw mut both, ptr::null_mut());
            }
            let met = both.hit.geometry != INVALID;
            *distance = if met { both.ray.t_far } else { f32::INFINITY };
        }
    }

    fn occluded(&self, rays: &[Ray], distances: &mut [f32]) {
        for (ray, distance) in rays.iter().zip(distances) {
            let mut query = RtcRay::new(ray);
            // SAFETY: as above.
            unsafe {
                (self.embree.functions.occluded)(self.scene, &raw mut query, ptr::null_mut());
            }
            let met = query.t_far == f32::NEG_INFINITY;
            *distance = if met { 0.0 } else { f32::INFINITY };
        }
    }
}

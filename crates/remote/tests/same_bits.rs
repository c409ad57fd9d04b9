//! A recovery has the same bits on any number of threads, by any number of workers, and when it continues from its
//! journal, wherever it was cut off.

use glam::{Vec2, Vec3};
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use unrender_paper::Paper;
use unrender_recover::{
    Effort, Expected, ExposureRule, GroupSpec, Hypothesis, Journal, Observation, Options, Picture,
    Problem, RecoverError, Recovery, Renderer, Role, View, recover, recover_with,
};
use unrender_remote::{Remote, Shared, Worker, Workers};
use unrender_render::{Settings, Tracer};
use unrender_scene::{Camera, Group, Image, Material, Mesh, Object, Rgb, RgbImage, Scene};

const SIDE: usize = 32;
const FLOOR: usize = 0;
const LAMP: usize = 2;

/// Records in memory; those of an earlier run come first.
struct Memory {
    records: Mutex<Vec<Vec<u8>>>,
    next: AtomicUsize,
}

impl Memory {
    fn new(records: &[Vec<u8>]) -> Self {
        Self { records: Mutex::new(records.to_vec()), next: AtomicUsize::new(0) }
    }

    fn into_records(self) -> Vec<Vec<u8>> {
        self.records.into_inner().unwrap()
    }
}

impl Journal for Memory {
    fn recall(&self, understand: &mut dyn FnMut(&[u8]) -> bool) -> bool {
        let next = self.next.load(Ordering::Relaxed);
        let records = self.records.lock().unwrap();
        let Some(record) = records.get(next) else { return false };
        assert!(understand(record), "record {next} is not understood");
        self.next.store(next + 1, Ordering::Relaxed);
        records.len() > next
    }

    fn keep(&self, found: &[u8]) {
        self.records.lock().unwrap().push(found.to_vec());
        self.next.fetch_add(1, Ordering::Relaxed);
    }
}

/// A glossy floor, a wall with a pattern, a lamp.
fn scene() -> Scene {
    let quads = [
        ("floor", [[-1., 0., 1.], [1., 0., 1.], [1., 0., -1.], [-1., 0., -1.]]),
        ("wall", [[-1., 0., -1.], [1., 0., -1.], [1., 2., -1.], [-1., 2., -1.]]),
        ("lamp", [[-0.4, 2., -0.4], [0.4, 2., -0.4], [0.4, 2., 0.4], [-0.4, 2., 0.4]]),
    ];
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    let mut scene = Scene::default();
    for (group, (name, corners)) in quads.into_iter().enumerate() {
        let corners = corners.map(Vec3::from_array);
        let mesh = Mesh::flat(&corners, &uvs, &[[0, 1, 2], [0, 2, 3]]);
        scene.objects.push(Object { name: name.into(), group, mesh });
        let emission = Rgb::splat(if group == LAMP { 6.0 } else { 0.0 });
        let material = Material::diffuse(Rgb::ZERO);
        scene.groups.push(Group { name: name.into(), material, emission });
    }
    scene.groups[FLOOR].material =
        Material::isotropic(Rgb::new(0.5, 0.3, 0.2), Rgb::ONE * 0.2, 0.2);
    scene.groups[1].material = Material::diffuse(Rgb::splat(0.6));
    scene
}

fn camera() -> Camera {
    let (eye, target) = (Vec3::new(0.3, 1.2, 2.6), Vec3::new(0.0, 0.6, 0.0));
    Camera::look_at("camera", eye, target, Vec3::Y, 0.7)
}

/// The result of `solve` for the problem of a photograph of the scene: a checkerboard hangs on the wall, and the
/// exposure is not known.
fn solved<T>(role_of_floor: Role, solve: impl Fn(&Problem<'_>) -> T) -> T {
    of_rungs(role_of_floor, &Hypothesis::ALL, solve)
}

/// The same where the unknown groups may have these hypotheses.
fn of_rungs<T>(role_of_floor: Role, rungs: &[Hypothesis], solve: impl Fn(&Problem<'_>) -> T) -> T {
    let scene = scene();
    let tracer = Tracer::new(&scene);
    let camera = camera();
    let view = View::new(&tracer, &camera, (SIDE, SIDE), scene.brdf);
    let settings = Settings { spp: 64, seed: 3, ..Settings::default() };
    let mut values = view.render(&scene.materials(), &settings, &|_| {}).mean;
    for (index, pixel) in values.pixels_mut().iter_mut().enumerate() {
        let dark = (index % SIDE / 8 + index / SIDE / 8).is_multiple_of(2);
        let on_wall = view.geometry().pixels()[index].group == 1;
        *pixel *= if dark && on_wall { 0.3 } else { 1.0 };
    }
    let picture = Picture {
        values,
        valid: Image::new(SIDE, SIDE, vec![true; SIDE * SIDE]),
        saturated: Image::new(SIDE, SIDE, vec![false; SIDE * SIDE]),
        quantisation_step: RgbImage::new(SIDE, SIDE, vec![Rgb::splat(1e-3); SIDE * SIDE]),
    };
    let observation = Observation::new(picture, view.geometry(), scene.groups.len());
    let spec = |(group, of_scene): (usize, &Group)| GroupSpec {
        name: of_scene.name.clone(),
        role: match group {
            LAMP => Role::Emitter,
            FLOOR => role_of_floor,
            _ => Role::Unknown,
        },
        material: of_scene.material.clone(),
        rungs: rungs.to_vec(),
        expected: Expected::default(),
    };
    let rho_d = Rgb::new(0.5, 0.3, 0.2);
    solve(&Problem {
        observation: &observation,
        renderer: &view,
        groups: scene.groups.iter().enumerate().map(spec).collect(),
        exposure: match role_of_floor {
            Role::Known => ExposureRule::Anchor { group: FLOOR, rho_d },
            _ => ExposureRule::Fixed(Rgb::ONE),
        },
        unknown_lights: Vec::new(),
        coloured_lights: Vec::new(),
        neighbouring_lights: Vec::new(),
        detail: None,
        photometric_parameters: &[],
    })
}

/// Workers in this process; now and then there is none, or an answer is cut off.
struct Here {
    count: usize,
    asked: AtomicUsize,
    fails: bool,
}

impl Workers for Here {
    fn count(&self) -> usize {
        self.count
    }

    fn answers(&self, shared: &[Shared; 3], requests: &[Vec<u8>]) -> Option<Vec<Vec<u8>>> {
        let [setup, appearance, cache] = shared.each_ref().map(|shared| &*shared.bytes);
        let worker = Worker::new(setup).unwrap();
        let answer = |request: &Vec<u8>| worker.answer(appearance, cache, request).unwrap();
        let mut answers: Vec<Vec<u8>> = requests.iter().map(answer).collect();
        match self.asked.fetch_add(1, Ordering::Relaxed) % 7 {
            0 if self.fails => return None,
            3 if self.fails => answers[0].truncate(5),
            _ => {}
        }
        Some(answers)
    }
}

/// All numbers of a recovery, to the bit: the text of a number reads back to the same bits.
fn bits(recovery: &Recovery) -> String {
    format!("{recovery:?}")
}

/// The kind of step that a record is of: its name comes first, after its length.
fn kind(record: &[u8]) -> String {
    String::from_utf8_lossy(&record[1..1 + usize::from(record[0])]).into_owned()
}

/// Cuts a recovery by `method` off after some of its steps, and lets it go on, where the unknown groups may have these
/// `rungs`. Returns the kinds of its steps.
fn goes_on(
    role_of_floor: Role,
    rungs: &[Hypothesis],
    method: impl Fn(&Problem<'_>, Option<&dyn Journal>) -> Result<Recovery, RecoverError>,
) -> BTreeSet<String> {
    of_rungs(role_of_floor, rungs, |problem| {
        let alone = bits(&method(problem, None).unwrap());
        let journal = Memory::new(&[]);
        let kept = bits(&method(problem, Some(&journal)).unwrap());
        assert_eq!(kept, alone, "keeping a journal changes nothing");
        let records = journal.into_records();
        let kinds: Vec<String> = records.iter().map(|record| kind(record)).collect();
        // After the first step of every kind, after half of them, and after all.
        let firsts = kinds.iter().collect::<BTreeSet<_>>().into_iter();
        let first = |name: &String| kinds.iter().position(|kind| kind == name).unwrap() + 1;
        let cuts: BTreeSet<usize> =
            firsts.map(first).chain([records.len() / 2, records.len()]).collect();
        for cut in cuts {
            let journal = Memory::new(&records[..cut]);
            let again = bits(&method(problem, Some(&journal)).unwrap());
            assert!(again == alone, "cut off after step {cut}, {}", kinds[cut - 1]);
            assert!(journal.into_records() == records, "cut off after step {cut}");
        }
        kinds.into_iter().collect()
    })
}

/// The default method.
fn by(
    options: &Options,
) -> impl Fn(&Problem<'_>, Option<&dyn Journal>) -> Result<Recovery, RecoverError> {
    |problem, journal| match journal {
        Some(journal) => recover_with(problem, options, &mut (), journal),
        None => recover(problem, options, &mut ()),
    }
}

#[test]
fn threads_change_no_bit() {
    let options = Options { effort: Effort::Draft, spp: 4, ..Options::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            solved(Role::Unknown, |problem| bits(&recover(problem, &options, &mut ()).unwrap()))
        })
    };
    let one = on(1);
    for threads in [2, 7] {
        assert!(on(threads) == one, "{threads} threads recover other numbers");
    }
}

#[test]
fn a_recovery_goes_on_to_the_same_bits() {
    let options = Options { effort: Effort::Draft, spp: 4, ..Options::default() };
    let kinds = goes_on(Role::Unknown, &Hypothesis::ALL, by(&options));
    for kind in ["candidates", "look", "verification", "pass", "texture", "other minima"] {
        assert!(kinds.contains(kind), "{kind}: {kinds:?}");
    }
}

#[test]
fn so_do_one_by_an_anchor_and_the_papers_ladder() {
    let effort = Effort::Draft;
    let options = Options { effort, spp: 2, refine: false, ..Options::default() };
    let kinds = goes_on(Role::Known, &Hypothesis::ALL, by(&options));
    assert!(kinds.contains("anchor"), "{kinds:?}");
    let paper = Paper { max_iterations: 16, ..Paper::default() };
    let kinds = goes_on(Role::Unknown, &Hypothesis::ALL, |problem, journal| {
        unrender_paper::recover(problem, &options, &paper, &mut (), journal)
    });
    for kind in ["paper's iteration", "paper's parameters"] {
        assert!(kinds.contains(kind), "{kind}: {kinds:?}");
    }
}

#[test]
fn workers_find_the_bits_of_one_machine() {
    let options = Options { effort: Effort::Draft, spp: 8, ..Options::default() };
    solved(Role::Known, |problem| {
        let alone = bits(&recover(problem, &options, &mut ()).unwrap());
        for (count, fails) in [(1, false), (2, true), (5, false), (0, false)] {
            let view = View::of_scene(&scene(), camera(), (SIDE, SIDE)).unwrap();
            let workers = Here { count, asked: AtomicUsize::new(0), fails };
            let remote = Remote::new(view, &scene(), &workers);
            let problem = Problem { renderer: &remote, ..problem.clone() };
            let together = bits(&recover(&problem, &options, &mut ()).unwrap());
            assert!(together == alone, "{count} workers");
            assert_eq!(workers.asked.into_inner() > 20, count > 0);
        }
    });
}

#[test]
fn a_worker_refuses_what_is_no_request_of_its_own() {
    assert!(Worker::new(&[1, 2, 3]).is_err());
    solved(Role::Known, |problem| {
        let view = View::of_scene(&scene(), camera(), (SIDE, SIDE)).unwrap();
        let refused = Refused::default();
        let remote = Remote::new(view, &scene(), &refused);
        let materials = scene().materials();
        let settings = Settings { spp: 1, ..Settings::default() };
        let pixels = [0, (SIDE * SIDE) as u32 - 1];
        // The renderer does it by itself.
        let seen = remote.rerender((&materials).into(), &pixels, &settings);
        let here = problem.renderer.rerender((&materials).into(), &pixels, &settings);
        assert_eq!(seen, here);
        assert!(refused.0.load(Ordering::Relaxed) > 0);
    });
}

/// Sends workers requests that they do not understand.
#[derive(Default)]
struct Refused(AtomicUsize);

impl Workers for Refused {
    fn count(&self) -> usize {
        1
    }

    fn answers(&self, shared: &[Shared; 3], requests: &[Vec<u8>]) -> Option<Vec<Vec<u8>>> {
        let [setup, appearance, cache] = shared.each_ref().map(|shared| &*shared.bytes);
        let worker = Worker::new(setup).unwrap();
        let request = &requests[0];
        assert!(worker.answer(appearance, cache, request).is_ok());
        assert!(worker.answer(&[], cache, request).is_err());
        assert!(worker.answer(appearance, &[7], request).is_err());
        assert!(worker.answer(appearance, cache, &request[..request.len() - 1]).is_err());
        // Pixels that the picture does not have.
        let mut beyond = request.clone();
        beyond[3] = 0x7F;
        assert!(worker.answer(appearance, cache, &beyond).is_err());
        self.0.fetch_add(1, Ordering::Relaxed);
        None
    }
}

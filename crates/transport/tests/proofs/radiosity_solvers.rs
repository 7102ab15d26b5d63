//! Radiosity: what solvers leave of the system, in which order patches shoot, and what the ambient term is.

use crate::radiosity::{meshed, one_wall, reciprocal};
use crate::stats::close;
use kaustika_scene::Scene;
use kaustika_spectra::Spectrum;
use kaustika_transport::Workers;
use kaustika_transport::method::RenderError;
use kaustika_transport::radiosity::form_factor::{FormFactorKind, FormFactors, Row};
use kaustika_transport::radiosity::solve::{
    Patches, Shooting, direct, gauss_seidel, jacobi, shoot,
};
use kaustika_transport::radiosity::{RadiosityParams, Solution};
use serde_json::json;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// The system of a room.
struct System {
    rows: Vec<Row>,
    patches: Patches,
}

impl System {
    fn new(scene: &Scene, patches: usize) -> System {
        let mesh = meshed(scene, patches);
        let ff = FormFactors::new(scene, &mesh, FormFactorKind::Analytic, 16, false);
        let none = vec![Spectrum::ZERO; ff.len()];
        let patches = Patches::new(&mesh, &ff.patches, &none, true);
        System { rows: reciprocal(&ff), patches }
    }

    /// S and ρ of a patch, in the first channel.
    fn of(&self, i: usize) -> [f64; 2] {
        [self.patches.source[i], self.patches.albedo[i]].map(|x| f64::from(x.0[0]))
    }

    /// Σ A of something over the patches.
    fn total(&self, of: impl Fn(usize) -> f64) -> f64 {
        self.patches.area.iter().enumerate().map(|(i, a)| f64::from(*a) * of(i)).sum()
    }

    /// Σ A ρ |F B - H|, B = S + ρH: what the equation is missed by.
    fn residual(&self, h: &[Spectrum]) -> f64 {
        let h = |i: usize| f64::from(h[i].0[0]);
        self.total(|i| {
            let mut gathered = 0.0;
            self.rows[i].each(|j, f| {
                let [s, rho] = self.of(j);
                gathered += f64::from(f.0[0]) * (s + rho * h(j));
            });
            self.of(i)[1] * (gathered - h(i)).abs()
        })
    }

    /// The irradiances after so many shots, and in which order patches shot and what that left.
    fn shot(&self, shooting: &Shooting) -> (Vec<Spectrum>, Vec<usize>, Vec<f32>) {
        let (mut order, mut left) = (Vec::new(), Vec::new());
        let row = |i: usize| {
            order.push(i);
            Some(self.rows[i].clone())
        };
        let (h, shots) = shoot(&self.patches, shooting, row, |l| left.push(l)).expect("done");
        assert_eq!((shots, shots), (order.len(), left.len()));
        (h, order, left)
    }
}

/// B = E + ρFB: an iteration may end when its geometric rest is `tolerance` of all light, by when it is missed by
/// less; shots, when they leave `tolerance` of what lamps send, of which at most ρ = 0.9 comes back. Elimination
/// leaves rounding. And none goes on when it may end.
#[test]
fn what_solvers_leave_is_within_the_tolerance() {
    let system = System::new(&one_wall().build(), 500);
    let (rows, patches) = (&system.rows, &system.patches);
    let reflected = |h: &[Spectrum]| system.total(|i| system.of(i)[1] * f64::from(h[i].0[0]));
    let eliminated = direct(rows, patches, || Some(())).expect("solved");
    let all = reflected(&eliminated);
    let left = system.residual(&eliminated) / all;
    assert!(left < 2e-6, "elimination leaves {left}");
    let sent = system.total(|i| system.of(i)[0]);
    let mut before = [f64::INFINITY; 3];
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let shooting = Shooting { tolerance, shots: 100_000, ambient: false };
        let found = [
            ("Jacobi", jacobi(rows, patches, tolerance), all),
            ("Gauss-Seidel", gauss_seidel(rows, patches, tolerance), all),
            ("Southwell", system.shot(&shooting).0, 0.9 * sent),
        ];
        for ((what, h, of), before) in found.into_iter().zip(&mut before) {
            let left = system.residual(&h) / of;
            assert!(left < f64::from(tolerance), "{what}: {left} of {tolerance}");
            assert!(left > 1e-3 * f64::from(tolerance), "{what}: {left} is more than was asked");
            assert!(left < *before, "{what}: {left} after {before}");
            *before = left;
        }
    }
}

/// Every shot is of the patch with the most unshot power, the first ones of the lamp's: after these, patches have
/// what the lamp sends them and no more. What is left falls with every shot, and is what is told.
#[test]
fn the_brightest_patches_shoot_first() {
    let system = System::new(&one_wall().build(), 500);
    let lamps = (0..system.rows.len()).filter(|&i| system.of(i)[0] > 0.0).count();
    let shooting = Shooting { tolerance: 1e-2, shots: 100_000, ambient: false };
    let (_, order, told) = system.shot(&shooting);
    assert!(lamps > 1 && order.len() > 2 * lamps, "{lamps} lamps, {} shots", order.len());
    let of_a_lamp = |i: &usize| system.of(*i)[0] > 0.0;
    assert!(order[..lamps].iter().all(of_a_lamp) && !of_a_lamp(&order[lamps]));
    let area = |i: usize| f64::from(system.patches.area[i]);
    let mut unshot: Vec<f64> = (0..system.rows.len()).map(|i| area(i) * system.of(i)[0]).collect();
    let sent: f64 = unshot.iter().sum();
    let mut left = 1.0;
    for (&i, &told) in order.iter().zip(&told) {
        let most = unshot.iter().copied().fold(0.0, f64::max);
        assert!(unshot[i] > (1.0 - 1e-4) * most, "{} shoots before {most}", unshot[i]);
        let shot = std::mem::take(&mut unshot[i]);
        system.rows[i].each(|j, f| unshot[j] += system.of(j)[1] * f64::from(f.0[0]) * shot);
        let now = unshot.iter().sum::<f64>() / sent;
        close("what is left", f64::from(told), now, 1e-4);
        assert!(now < left, "{now} after {left}");
        left = now;
    }
    assert!(left < 1e-2);
    let (first, ..) = system.shot(&Shooting { tolerance: 0.0, shots: lamps, ambient: false });
    for (i, h) in first.iter().enumerate() {
        let mut from_lamps = 0.0;
        system.rows[i].each(|j, f| from_lamps += f64::from(f.0[0]) * system.of(j)[0]);
        let off = (f64::from(h.0[0]) - from_lamps).abs();
        assert!(off < 1e-4 * from_lamps.max(1e-3), "{h:?}, not {from_lamps}");
    }
}

/// The ambient term is one number for all patches, which no shot counts: the shots are the same with it, what is left
/// is the same, and where nothing is left it is nothing.
#[test]
fn the_ambient_term_is_for_display_alone() {
    let system = System::new(&one_wall().build(), 500);
    let sent = system.total(|i| system.of(i)[0]);
    let area = system.total(|_| 1.0);
    let rho = system.total(|i| system.of(i)[1]) / area;
    for (shots, tolerance) in [(4, 0.0), (40, 0.0), (400, 0.0), (100_000, 1e-5)] {
        let run = |ambient| system.shot(&Shooting { tolerance, shots, ambient });
        let ((bare, order, left), (with, other_order, other_left)) = (run(false), run(true));
        assert_eq!((&order, &left), (&other_order, &other_left));
        let left = f64::from(*left.last().expect("shots"));
        let ambient = left * sent / area / (1.0 - rho);
        let most = bare.iter().map(|h| f64::from(h.0[0])).fold(0.0, f64::max);
        for (a, b) in bare.iter().zip(&with) {
            let added = f64::from(b.0[0]) - f64::from(a.0[0]);
            let off = (added - ambient).abs();
            assert!(off < 1e-4 * ambient + 1e-6 * most, "{shots} shots: {added}, not {ambient}");
        }
        assert!(shots < 1000 || ambient < 1e-4 * most, "{ambient} of {most} is left");
    }
}

/// Rows of form factors, shots and lines of the elimination end where they are when it is cancelled: with one thread no
/// more of them are told of.
#[test]
fn matrices_end_when_cancelled() {
    let scene = one_wall().build();
    for (solver, extended) in [("jacobi", false), ("southwell", true), ("direct", false)] {
        let cancel = Arc::new(AtomicBool::new(false));
        let (told, flag) = (Arc::new(AtomicUsize::new(0)), cancel.clone());
        let heard = told.clone();
        let workers = Workers::new(1, cancel).expect("threads").told_to(move |text| {
            if text.starts_with("form factors of 100 ") || flag.load(Ordering::Relaxed) {
                heard.fetch_add(1, Ordering::Relaxed);
                flag.store(true, Ordering::Relaxed);
            }
        });
        let p = json!({"solver": solver, "extended": extended, "patches": 2000});
        let p: RadiosityParams = serde_json::from_value(p).expect("parameters");
        let found = Solution::new(&scene, &p, &workers);
        assert!(matches!(found, Err(RenderError::Cancelled)), "{solver}");
        assert_eq!(told.load(Ordering::Relaxed), 1, "{solver}");
    }
    let system = System::new(&scene, 200);
    let asked = AtomicUsize::new(0);
    let go_on = || (asked.fetch_add(1, Ordering::Relaxed) < 10).then_some(());
    assert!(direct(&system.rows, &system.patches, go_on).is_none());
    assert_eq!(asked.into_inner(), 11);
}

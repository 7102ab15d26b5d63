//! The command line.

use kaustika::transport::{Budget, Observer, Progress, Session, Workers};
use kaustika::{RenderOptions, Setup, load, output};
use kaustika_film::accumulate::PassTree;
use std::path::Path;

struct Silent;
impl Observer for Silent {
    fn committed(&mut self, _: &Progress, _: &PassTree) {}
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let d = load(Path::new(&args[0]), &[]);
    for e in &d.diagnostics.entries {
        let at = e.span.map(|s| d.sources.location(s)).unwrap_or_default();
        eprintln!("{:?} {at}: {} {} {:?}", e.severity, e.message, e.label, e.hint);
    }
    let mut o = RenderOptions { spp: args[2].parse().ok(), ..Default::default() };
    for a in &args[3..] {
        let (k, v) = a.split_once('=').unwrap();
        match k {
            "res" => {
                let (w, h) = v.split_once('x').unwrap();
                o.resolution = Some([w.parse().unwrap(), h.parse().unwrap()]);
            }
            "sampler" => o.sampler = v.parse().ok(),
            "mode" => {
                o.mode = Some(if v == "rgb" {
                    kaustika::spectra::ColorMode::Rgb
                } else {
                    kaustika::spectra::ColorMode::Spectral
                })
            }
            _ => o.parameters.push((k.into(), v.into())),
        }
    }
    let setup = Setup::new(&d, &o).unwrap();
    let workers = Workers::new(0, Default::default()).unwrap();
    let spp = setup.spp;
    let Setup { scene, frame, method, .. } = &setup;
    let _ = method;
    let entry = kaustika::transport::registry::find("path").unwrap();
    let mut s = Session::new(scene, frame, (entry.make)(&setup.parameters).unwrap());
    let r = s
        .run(&Budget { end_pass: Some(spp), ..Default::default() }, &workers, &mut Silent)
        .unwrap();
    println!("{:?}", r);
    let p = output::picture(&s.tree, &setup);
    kaustika_film::write_picture(&args[1], &p, &Default::default()).unwrap();
}

// Tests an odometry on the drives of `diffdrive suite`: rustc --edition 2021 -O suite.rs && ./suite cases/*.csv
use std::{collections::HashMap, env, error::Error, f64::consts::PI, fs, process};

struct Odometry { x: f64, y: f64, theta: f64, radii: [f64; 2], track: f64, bits: i32, last: Option<[f64; 3]> }

impl Odometry {
    fn new(header: &HashMap<&str, f64>, ticks: bool) -> Self {
        let tick = if ticks { 2.0 * PI / header["ticks_per_revolution"] } else { 1.0 };
        Self {
            x: header["x"], y: header["y"], theta: header["theta"],
            radii: [tick * header["left_radius"], tick * header["right_radius"]], // metres for each unit read
            track: header["track_width"], bits: header.get("counter_bits").map_or(0, |&n| n as i32), last: None,
        }
    }

    fn update(&mut self, now: [f64; 3]) {
        let late = self.last.is_some_and(|last| now[0] <= last[0]);
        if late || now.iter().any(|value| !value.is_finite()) { return; } // holds the pose
        if let Some(last) = self.last {
            let [left, right] = [0, 1].map(|k| self.radii[k] * self.step(now[k + 1] - last[k + 1]));
            let half = (right - left) / self.track / 2.0;
            let chord = (left + right) / 2.0 * if half == 0.0 { 1.0 } else { half.sin() / half };
            self.x += chord * (self.theta + half).cos();
            self.y += chord * (self.theta + half).sin();
            self.theta += 2.0 * half;
        }
        self.last = Some(now);
    }

    fn step(&self, ticks: f64) -> f64 {
        let range = 2f64.powi(self.bits);
        if self.bits > 0 { ticks - range * (ticks / range + 0.5).floor() } else { ticks }
    }
}

fn passes(path: &str) -> Result<bool, Box<dyn Error>> {
    let text = fs::read_to_string(path)?;
    let mut lines = text.lines();
    let pairs = lines.next().ok_or("no header")?.split(' ').filter_map(|word| word.split_once('='));
    let header: HashMap<&str, f64> = pairs.filter_map(|(name, value)| Some((name, value.parse().ok()?))).collect();
    let mut odometry = Odometry::new(&header, text.contains("unit=ticks"));
    let mut worst = 0.0;
    for line in lines.skip(1) {
        let row = line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        odometry.update([row[0], row[1], row[2]]);
        let angle = odometry.theta - row[5];
        let turn = (angle - 2.0 * PI * (angle / (2.0 * PI)).round()) * odometry.track / 2.0;
        let gap = (odometry.x - row[3]).hypot(odometry.y - row[4]).hypot(turn);
        worst = if gap <= worst { worst } else if gap.is_finite() { gap } else { f64::INFINITY };
    }
    let most = header["tolerance"];
    let ok = worst <= most;
    println!("{} {path}: off by {worst:.1e} m, at most {most:.1e} m", if ok { "ok  " } else { "FAIL" });
    Ok(ok)
}

fn main() -> Result<(), Box<dyn Error>> {
    let results = env::args().skip(1).map(|path| passes(&path)).collect::<Result<Vec<_>, _>>()?;
    process::exit(results.contains(&false) as i32)
}

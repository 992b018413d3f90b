//! A log-log plot as SVG.

use std::fmt::Write;

/// A curve: its name and its points, all positive.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its name in the legend.
    pub name: String,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 440.0;
/// Left, top, right and bottom border.
const BORDER: [f64; 4] = [80.0, 40.0, 190.0, 50.0];
const COLOURS: [&str; 6] = ["#1b6ca8", "#c8553d", "#3d8b37", "#7b4fa3", "#b8860b", "#444444"];

/// One axis: decades from `first` to `last`, over the pixels `from` to `to`.
struct Axis {
    first: i32,
    last: i32,
    from: f64,
    to: f64,
}

impl Axis {
    fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let (least, greatest) = values
            .map(libm::log10)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), value| {
                (value.min(least), value.max(greatest))
            });
        let (first, last) = if least > greatest {
            (0, 1)
        } else {
            (libm::floor(least) as i32, libm::ceil(greatest) as i32)
        };
        Self { first, last: last.max(first + 1), from, to }
    }

    fn at(&self, value: f64) -> f64 {
        let share =
            (libm::log10(value) - f64::from(self.first)) / f64::from(self.last - self.first);
        self.from + share * (self.to - self.from)
    }

    /// The values at which lines are drawn, and whether each is a power of ten.
    fn ticks(&self) -> impl Iterator<Item = (f64, bool)> {
        let decades = self.first..=self.last;
        let (least, greatest) = (power_of_ten(self.first), power_of_ten(self.last));
        let ticks = decades.flat_map(|decade| {
            (1..10).map(move |digit| (f64::from(digit) * power_of_ten(decade), digit == 1))
        });
        ticks.filter(move |(value, _)| *value >= 0.999 * least && *value <= 1.001 * greatest)
    }
}

fn power_of_ten(exponent: i32) -> f64 {
    libm::pow(10.0, f64::from(exponent))
}

/// Draws curves; points that are not positive are left out, since they have no logarithm.
pub fn log_log(title: &str, x_name: &str, y_name: &str, curves: &[Curve]) -> String {
    let drawn = |curve: &Curve| {
        curve
            .points
            .iter()
            .copied()
            .filter(|point| point.0 > 0.0 && point.1 > 0.0)
            .collect::<Vec<_>>()
    };
    let points: Vec<(f64, f64)> = curves.iter().flat_map(drawn).collect();
    let x = Axis::over(points.iter().map(|point| point.0), BORDER[0], WIDTH - BORDER[2]);
    let y = Axis::over(points.iter().map(|point| point.1), HEIGHT - BORDER[3], BORDER[1]);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"{}\" y=\"24\" font-size=\"15\">{}</text>\n",
        BORDER[0],
        escaped(title)
    );
    draw_grid(&mut svg, &x, &y);
    let names = format!(
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n\
         <text transform=\"translate(18 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
        0.5 * (x.from + x.to),
        HEIGHT - 12.0,
        escaped(x_name),
        0.5 * (y.from + y.to),
        escaped(y_name)
    );
    svg.push_str(&names);
    for (index, curve) in curves.iter().enumerate() {
        draw_curve(&mut svg, (&x, &y), index, &curve.name, &drawn(curve));
    }
    svg.push_str("</svg>\n");
    svg
}

fn draw_grid(svg: &mut String, x: &Axis, y: &Axis) {
    for (value, whole) in x.ticks() {
        let at = x.at(value);
        draw_grid_line(svg, &format!("M{at:.1} {:.1}V{:.1}", y.from, y.to), whole);
        if whole {
            draw_number(svg, [at, y.from + 18.0], "middle", value);
        }
    }
    for (value, whole) in y.ticks() {
        let at = y.at(value);
        draw_grid_line(svg, &format!("M{:.1} {at:.1}H{:.1}", x.from, x.to), whole);
        if whole {
            draw_number(svg, [x.from - 8.0, at + 4.0], "end", value);
        }
    }
}

fn draw_grid_line(svg: &mut String, path: &str, whole: bool) {
    let colour = if whole { "#b0b0b0" } else { "#e8e8e8" };
    let _ = writeln!(svg, "<path d=\"{path}\" stroke=\"{colour}\"/>");
}

fn draw_number(svg: &mut String, [x, y]: [f64; 2], anchor: &str, value: f64) {
    let text = label(value);
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>");
}

fn draw_curve(
    svg: &mut String,
    (x, y): (&Axis, &Axis),
    index: usize,
    name: &str,
    points: &[(f64, f64)],
) {
    let colour = COLOURS[index % COLOURS.len()];
    let places: Vec<(f64, f64)> =
        points.iter().map(|point| (x.at(point.0), y.at(point.1))).collect();
    let line: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
        line.join(" ")
    );
    for (x, y) in &places {
        let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"{colour}\"/>");
    }
    let (left, top) = (x.to + 14.0, y.to + 12.0 + 20.0 * index as f64);
    let _ = writeln!(
        svg,
        "<path d=\"M{left:.1} {:.1}h20\" stroke=\"{colour}\" stroke-width=\"2\"/>",
        top - 4.0
    );
    let _ = writeln!(svg, "<text x=\"{:.1}\" y=\"{top:.1}\">{}</text>", left + 26.0, escaped(name));
}

fn label(value: f64) -> String {
    if (0.001..1e4).contains(&value) { format!("{value}") } else { format!("{value:e}") }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_ratios_are_equal_distances() {
        let axis = Axis::over([0.002, 0.5].into_iter(), 0.0, 300.0);
        assert_eq!((axis.first, axis.last), (-3, 0));
        assert!((axis.at(0.1) - axis.at(0.01) - 100.0).abs() < 1e-9);
        assert_eq!(axis.ticks().filter(|(_, whole)| *whole).count(), 4);
    }

    #[test]
    fn every_positive_point_is_drawn_and_names_are_escaped() {
        let curve =
            Curve { name: "a<b".into(), points: vec![(1.0, 10.0), (2.0, 20.0), (4.0, 0.0)] };
        let svg = log_log("t", "x & y", "s", &[curve]);
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(svg.contains("a&lt;b") && svg.contains("x &amp; y") && svg.ends_with("</svg>\n"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn nothing_to_draw_is_still_a_picture() {
        assert!(log_log("t", "x", "y", &[]).contains("<svg"));
    }
}

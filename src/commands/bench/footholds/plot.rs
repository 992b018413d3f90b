//! Success over span as SVG. A few lines and circles: written by hand, a plotting crate would bring
//! more code than it saves.

use std::fmt::Write;

/// A curve: its name and its points, percent over percent.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its name in the legend.
    pub name: &'static str,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

/// The picture's size and borders (left, top, right, bottom), px.
const SIZE: (f64, f64) = (760.0, 420.0);
const BORDER: [f64; 4] = [60.0, 40.0, 190.0, 50.0];
/// The spans that the x axis shows, percent.
const SPANS: (f64, f64) = (60.0, 130.0);
const COLOURS: [&str; 4] = ["#444444", "#c8553d", "#3d8b37", "#1b6ca8"];

/// Draws success over the bars' span, as figure 4.10 does.
pub fn figure_4_10(curves: &[Curve]) -> String {
    let (width, height) = SIZE;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"{}\" y=\"24\" font-size=\"15\">Parallel bars: queries with a placement</text>\n",
        BORDER[0]
    );
    for tick in (0..=10).map(|tick| 10.0 * f64::from(tick)) {
        let (left, y) = place(SPANS.0, tick);
        let _ = writeln!(
            svg,
            "<path d=\"M{left:.1} {y:.1}H{:.1}\" stroke=\"#dddddd\"/>",
            place(SPANS.1, tick).0
        );
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{tick} %</text>",
            left - 6.0,
            y + 4.0
        );
    }
    for tick in (0..=7).map(|tick| SPANS.0 + 10.0 * f64::from(tick)) {
        let (x, bottom) = place(tick, 0.0);
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {bottom:.1}V{:.1}\" stroke=\"#dddddd\"/>",
            place(tick, 100.0).1
        );
        let _ = writeln!(
            svg,
            "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{tick} %</text>",
            bottom + 18.0
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\">outer span of the bars, of the sole's length</text>",
        BORDER[0],
        height - 10.0
    );
    curves.iter().enumerate().for_each(|(index, curve)| draw(&mut svg, index, curve));
    svg.push_str("</svg>\n");
    svg
}

fn draw(svg: &mut String, index: usize, curve: &Curve) {
    let colour = COLOURS[index % COLOURS.len()];
    let places: Vec<(f64, f64)> =
        curve.points.iter().map(|&(span, share)| place(span, share)).collect();
    let line: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
        line.join(" ")
    );
    for (x, y) in places {
        let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\"/>");
    }
    let (left, top) = (SIZE.0 - BORDER[2] + 20.0, BORDER[1] + 14.0 + 20.0 * index as f64);
    let _ = writeln!(
        svg,
        "<path d=\"M{left:.1} {:.1}h20\" stroke=\"{colour}\" stroke-width=\"2\"/>",
        top - 4.0
    );
    let _ = writeln!(svg, "<text x=\"{:.1}\" y=\"{top:.1}\">{}</text>", left + 26.0, curve.name);
}

/// Where a span and a share, in percent, lie in the picture.
fn place(span: f64, share: f64) -> (f64, f64) {
    let (width, height) = (SIZE.0 - BORDER[0] - BORDER[2], SIZE.1 - BORDER[1] - BORDER[3]);
    (
        BORDER[0] + width * (span - SPANS.0) / (SPANS.1 - SPANS.0),
        BORDER[1] + height * (1.0 - share / 100.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_drawn_where_it_belongs() {
        let svg = figure_4_10(&[Curve { name: "one", points: vec![(60.0, 100.0), (130.0, 0.0)] }]);
        assert!(svg.contains("points=\"60.0,40.0 570.0,370.0\""), "{svg}");
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(svg.contains(">one</text>") && svg.ends_with("</svg>\n"));
    }
}

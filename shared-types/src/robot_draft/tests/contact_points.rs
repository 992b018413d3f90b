//! Feet that stand on balls in simulators, as Leju's Kuavo.

use super::*;

/// Hubo with a foot whose collision box ends above its sole, on four balls that are links fixed to
/// it and reach 5 mm below.
fn on_balls(text: &str, side: &str) -> String {
    let text = changed(text, &format!("<link name=\"{side}_foot\""), "</link>", |link| {
        let (head, tail) = link.split_once("<collision>").unwrap();
        let (shape, _) = tail.split_once("</collision>").unwrap();
        let raised = replaced(shape, "xyz=\"0.02 0 -0.1\"", "xyz=\"0.02 0 -0.06\"");
        format!("{head}<visual>{shape}</visual><collision>{raised}</collision></link>")
    });
    let ball = |at: usize| {
        let (x, y) = ([0.13, 0.13, -0.09, -0.09][at], [0.07, -0.07, 0.07, -0.07][at]);
        let link = format!("{side}_ball_{at}");
        format!(
            "<link name=\"{link}\"><collision><geometry><sphere radius=\"0.005\"/></geometry>\
             </collision></link><joint name=\"{link}_joint\" type=\"fixed\">\
             <parent link=\"{side}_foot\"/><child link=\"{link}\"/>\
             <origin xyz=\"{x} {y} -0.12\"/></joint>"
        )
    };
    let balls: String = (0..4).map(ball).collect();
    replaced(&text, "</robot>", &(balls + "</robot>"))
}

#[test]
fn a_foot_on_balls_of_other_links_stands_on_its_looks() {
    let (draft, model) = drafted(&on_balls(&on_balls(&hubo(), "left"), "right"));
    let names: Vec<&str> = draft.visual_shapes.iter().map(|link| link.name.as_str()).collect();
    let expected = ["foot", "ball_0", "ball_1", "ball_2", "ball_3"];
    for side in ["left", "right"] {
        for link in expected {
            assert!(names.contains(&format!("{side}_{link}").as_str()), "{names:?}");
        }
    }
    for foot in &model.feet {
        assert!((foot.link_from_sole.translation.z + 0.12).abs() < 1e-6, "{foot:?}");
        assert!((polygon_area(&foot.polygon) - 0.22 * 0.14).abs() < 1e-6);
        let shapes = &model.links[foot.link].shapes;
        assert!(shapes.iter().all(|part| !matches!(part.shape, Shape::Sphere { .. })));
    }
}

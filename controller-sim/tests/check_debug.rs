use std::path::Path;
use surefoot_controller_sim::geometry::body::{Body, Placed};
use surefoot_controller_sim::geometry::separation::separation;
use surefoot_controller_sim::geometry::solid::*;
use surefoot_controller_sim::kinematics::*;
use surefoot_shared_types::plan_file::load::load_plan;
use surefoot_shared_types::robot::load::robot_from_block;
use surefoot_shared_types::Pose;
use parry3d_f64::shape::ConvexPolyhedron;
#[test]
fn debug() {
    let path = Path::new("/work/shared/judge/examples/g1_terrain.json");
    let plan = load_plan(path).unwrap();
    let model = robot_from_block(&plan.robot, path.parent().unwrap(), path).unwrap();
    let bodies = Body::of_robot(&model).unwrap();
    let w = &plan.waypoints[0];
    let find = |n: &str| bodies.iter().position(|b| b.name == n).unwrap();
    let (a, b) = (find("left_knee_link"), find("left_ankle_roll_link"));
    for (k, body) in bodies.iter().enumerate() { println!("{k} {} {:?}", body.name, body.local_bounds); }
    let q0: Vec<f64> = model.joints.iter().map(|j| 0f64.max(j.lower).min(j.upper)).collect();
    let q1: Vec<f64> = model.joints.iter().map(|j| w.q[plan.joint_names.iter().position(|n| *n == j.name).unwrap()]).collect();
    for q in [q0, q1] {
        let p = Posture::new(&model, &Configuration { world_from_root: Pose::IDENTITY, q });
        let pl = |i: usize| Placed::new(&bodies[i], &p.world_from_link[bodies[i].link.unwrap()]);
        let (pa, pb) = (pl(a), pl(b));
        for h in [glam::DVec3::Z, -glam::DVec3::Z, glam::DVec3::X] {
            println!("{:?}", separation((&bodies[a].solid, &pa), (&bodies[b].solid, &pb), h, 10.0));
        }
        if let (Solid::Convex(Convex { core: Core::Points(x), .. }), Solid::Convex(Convex { core: Core::Points(y), .. })) = (&bodies[a].solid, &bodies[b].solid) {
            println!("{} {}", x.len(), y.len());
            let (x, y) = (ConvexPolyhedron::from_convex_hull(x).unwrap(), ConvexPolyhedron::from_convex_hull(y).unwrap());
            println!("parry {:?}", parry3d_f64::query::contact(&pa.world_from_solid, &x, &pb.world_from_solid, &y, 1.0));
        }
    }
}

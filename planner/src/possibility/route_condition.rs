//! What the vertices and edges of Gamma_P must satisfy.

/// The conditions of stage P, strictest first. Each search begins with the first; where it finds no
/// route, the next one follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RouteCondition {
    /// The whole upper body is free in some crouch, both feet have placements, and a prepared
    /// posture steps between vertices.
    UpperBody,
    /// As `UpperBody`, but of the upper body only the links fixed to the root need be free.
    Root,
    /// The whole upper body is free at a root pose of any height and lean that the vertex carries,
    /// and along a path in SE(3) to the next.
    Leaning,
    /// C_N alone: at some root pose near the vertex the links fixed to the root are free, and some
    /// part of the world is where a sole may be. Implied by every walk.
    Necessary,
}

//! Pairs of links that mirror each other, and which of the two is the left one.

/// The side of a link by its name, seen from its partner's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Right,
}

/// The side of the first of two names that differ in "left" and "right", or in "l" and "r";
/// `None` for other names.
pub(crate) fn side_of(name: &str, partner: &str) -> Option<Side> {
    let (name, partner) = (name.to_lowercase(), partner.to_lowercase());
    if name == partner {
        return None;
    }
    let swapped = |name: &str| name.replace("left", "\u{1}").replace("right", "\u{2}");
    let (a, b) = (swapped(&name), swapped(&partner));
    if a.replace('\u{1}', "\u{2}") == b {
        return Some(Side::Left);
    }
    if b.replace('\u{1}', "\u{2}") == a {
        return Some(Side::Right);
    }
    if name.chars().count() != partner.chars().count() {
        return None;
    }
    let mut differing = name.chars().zip(partner.chars()).filter(|(a, b)| a != b);
    let first = differing.next()?;
    let is_alike = differing.all(|pair| pair == first);
    match first {
        ('l', 'r') if is_alike => Some(Side::Left),
        ('r', 'l') if is_alike => Some(Side::Right),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_show_the_side() {
        for (left, right) in [
            ("left_foot", "right_foot"),
            ("LeftFootLeft", "RightFootRight"),
            ("l_ankle", "r_ankle"),
            ("LLEG_LINK6", "RLEG_LINK6"),
            ("leg_left_6_link", "leg_right_6_link"),
            ("foot_l", "foot_r"),
        ] {
            assert_eq!(side_of(left, right), Some(Side::Left), "{left}");
            assert_eq!(side_of(right, left), Some(Side::Right), "{right}");
        }
        for (a, b) in [("foot_1", "foot_2"), ("a", "a"), ("l_foot", "r_hand"), ("lr", "rl")] {
            assert_eq!(side_of(a, b), None, "{a} {b}");
        }
    }
}

//! What both axes may do.

/// Limits of one axis, SI.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Of m/s² or rad/s².
    pub acceleration: f64,
    /// Of m/s³ or rad/s³.
    pub jerk: f64,
}

/// Limits of both axes.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Along the path.
    pub travel: Axis,
    /// Of the heading.
    pub heading: Axis,
}

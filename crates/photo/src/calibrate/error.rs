//! Errors of calibration, with remedies.

/// Why calibration failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrateError {
    /// Fewer pairs than the parameters need.
    #[error(
        "{there} pairs are too few for {numbers} (with {unknowns} unknowns), which need {needed}; \
         measure more{hint}"
    )]
    TooFew {
        /// How many pairs there are.
        there: usize,
        /// How many there must be.
        needed: usize,
        /// The requested parameters, in words.
        numbers: String,
        /// The number of unknowns.
        unknowns: usize,
        /// Another remedy, if there is one.
        hint: String,
    },
    /// The points lie on one line, or all at one place.
    #[error(
        "the points lie on one straight line ({length:.3} m long, {width:.3} m wide), about which \
         the camera could turn freely; measure some beside it"
    )]
    Collinear {
        /// The spread along the line, metres.
        length: f64,
        /// The spread across it, metres.
        width: f64,
    },
    /// Points in one plane do not determine focal length and principal point at once.
    #[error(
        "the points lie in one plane, which does not determine both the principal point and the \
         focal length; measure points off the plane, or leave one of the two out"
    )]
    CoplanarPrincipalPoint,
    /// The pairs fit a mirrored world only.
    #[error(
        "the pairs fit together only as seen in a mirror ({mirrored_px:.1} px off; unmirrored \
         {plain_px:.1} px): x_px counts from the left and y_px from the top, the photo must not be \
         flipped, and the points' axes must be right-handed: with y up and x to the right, z comes \
         towards you"
    )]
    Mirrored {
        /// The residual of most pairs with the world mirrored, pixels.
        mirrored_px: f64,
        /// The residual of most pairs as they are, pixels.
        plain_px: f64,
    },
    /// No camera agrees with most pairs.
    #[error(
        "no camera fits most of the pairs: the best one fits {agreeing} of {there} (to {scale_px:.1} \
         px), and at least {needed} are needed; check which point is which, and that the points \
         are in metres with y up"
    )]
    NoConsensus {
        /// How many pairs agree.
        agreeing: usize,
        /// How many pairs there are.
        there: usize,
        /// How many would have to agree.
        needed: usize,
        /// The residual of the best 60 % of the pairs, pixels.
        scale_px: f64,
    },
    /// A parameter that the pairs do not determine.
    #[error("the pairs do not determine {what}; {remedy}")]
    Undetermined {
        /// The parameter.
        what: String,
        /// What to do.
        remedy: String,
    },
}

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
    /// Too few lines, or along too few axes.
    #[error(
        "{needed} axes need two lines each, {lines} lines in all; there are {} along x, {} along y and {} along z", counts[0],
        counts[1], counts[2]
    )]
    FewDirections {
        /// The lines along x, y and z.
        counts: [usize; 3],
        /// How many axes must have two lines.
        needed: usize,
        /// How many lines there must be.
        lines: usize,
    },
    /// A photograph in which no two perpendicular directions are found.
    #[error(
        "the {there} straight lines of the photo show no two perpendicular directions; mark lines yourself, in a file \
         for --lines"
    )]
    NoDirections {
        /// How many straight lines there are.
        there: usize,
    },
    /// No camera agrees with most lines.
    #[error(
        "no camera fits most of the lines: the best one fits {agreeing} of {there} (to {scale_px:.1} px), and at least \
         {needed} are needed; check which axis each is parallel to, and that the photo is not a crop from one side"
    )]
    LinesDisagree {
        /// How many lines agree.
        agreeing: usize,
        /// How many lines there are.
        there: usize,
        /// How many would have to agree.
        needed: usize,
        /// The residual of the best 60 % of the lines, pixels.
        scale_px: f64,
    },
    /// The line of known length cannot be where it is seen.
    #[error(
        "line \"{name}\", whose length is known, would be behind the camera; its first end is where its axis begins, its \
         second is further along it"
    )]
    LineBehind {
        /// Its name.
        name: String,
    },
    /// A parameter that the pairs or lines do not determine.
    #[error("{what} is not determined; {remedy}")]
    Undetermined {
        /// The parameter.
        what: String,
        /// What to do.
        remedy: String,
    },
}

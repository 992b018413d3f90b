//! One finding of `surefoot doctor`.

/// A finding, printed as one line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Finding {
    grade: Grade,
    text: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Grade {
    Good,
    Advice,
    Missing,
}

impl Finding {
    /// A requirement that is met.
    pub(crate) fn good(text: impl Into<String>) -> Self {
        Self { grade: Grade::Good, text: text.into() }
    }

    /// Advice: walks run, but not as well as they could.
    pub(crate) fn advice(text: impl Into<String>) -> Self {
        Self { grade: Grade::Advice, text: text.into() }
    }

    /// A requirement of every walk that is not met.
    pub(crate) fn missing(text: impl Into<String>) -> Self {
        Self { grade: Grade::Missing, text: text.into() }
    }

    /// Whether a requirement is not met.
    pub(crate) fn is_missing(&self) -> bool {
        self.grade == Grade::Missing
    }

    /// The line that is printed.
    pub(crate) fn line(&self) -> String {
        let label = match self.grade {
            Grade::Good => "good",
            Grade::Advice => "advice",
            Grade::Missing => "MISSING",
        };
        format!("{label:<8} {}", self.text)
    }
}

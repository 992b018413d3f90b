//! Columns of the grid that wait for their turn.

/// Columns that wait for their turn.
#[derive(Debug)]
pub(crate) struct ColumnQueue {
    columns: Vec<u32>,
    first: usize,
    len: usize,
}

impl ColumnQueue {
    /// An empty queue with memory for `columns_max` columns. Allocates.
    pub fn new(columns_max: usize) -> Self {
        Self { columns: vec![0; columns_max], first: 0, len: 0 }
    }

    /// Removes all columns.
    pub fn clear(&mut self) {
        (self.first, self.len) = (0, 0);
    }

    /// Number of columns.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Adds a column; there must be memory for it.
    pub fn push(&mut self, column: usize) {
        let at = (self.first + self.len) % self.columns.len();
        self.columns[at] = column as u32;
        self.len += 1;
    }

    /// Removes the column that has waited longest.
    pub fn pop(&mut self) -> Option<usize> {
        let column = (self.len > 0).then(|| self.columns[self.first] as usize)?;
        (self.first, self.len) = ((self.first + 1) % self.columns.len(), self.len - 1);
        Some(column)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        size_of_val(self.columns.as_slice())
    }
}

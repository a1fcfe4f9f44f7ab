//! A sequence of values that is thinned out as it grows.

/// Values with their numbers in the sequence: those whose number is a multiple of the stride, and the last one.
#[derive(Clone, Debug)]
pub struct Thinned<T> {
    kept: Vec<(usize, T)>,
    last: Option<(usize, T)>,
    most: usize,
    /// Every `stride`-th value is kept
    pub stride: usize,
    /// Number of values so far
    pub count: usize,
}

impl<T> Thinned<T> {
    /// Creates an empty sequence that keeps at most `most` values, and the last one.
    pub fn new(most: usize) -> Self {
        Self { kept: vec![], last: None, most, stride: 1, count: 0 }
    }

    pub fn push(&mut self, value: T) {
        let number = self.count;
        self.count += 1;
        if !number.is_multiple_of(self.stride) {
            self.last = Some((number, value));
            return;
        }
        self.last = None;
        self.kept.push((number, value));
        if self.kept.len() > self.most {
            self.stride *= 2;
            let stride = self.stride;
            let of_stride = |(number, _): &(usize, T)| number.is_multiple_of(stride);
            self.last = self.kept.pop_if(|value| !of_stride(value));
            self.kept.retain(of_stride);
        }
    }

    /// Returns the kept values from number `first` on, in order.
    pub fn from(&self, first: usize) -> impl Iterator<Item = &(usize, T)> {
        self.kept.iter().chain(&self.last).skip_while(move |(number, _)| *number < first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_last_value_are_kept_and_the_others_at_equal_distances() {
        for count in 1..200 {
            let mut values = Thinned::new(8);
            (0..count).for_each(|k| values.push(10 * k));
            let kept: Vec<(usize, usize)> = values.from(0).copied().collect();
            assert!(kept.len() <= 9 && kept.iter().all(|(number, value)| *value == 10 * number), "{kept:?}");
            assert_eq!((kept[0].0, kept[kept.len() - 1].0, values.count), (0, count - 1, count));
            assert!(kept[..kept.len() - 1].iter().enumerate().all(|(k, (number, _))| *number == k * values.stride));
            assert!(values.from(count / 2).all(|(number, _)| *number >= count / 2));
        }
    }
}

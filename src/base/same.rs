//! Values whose type is known at run time.

use std::any::Any;

/// `value` as a `B`, if that is its type; `None` else. Lets code for any number of dimensions call
/// what exists for the plane or for space alone.
pub fn same<A: Any, B: Any>(value: A) -> Option<B> {
    let mut value = Some(value);
    let value: &mut dyn Any = &mut value;
    value.downcast_mut::<Option<B>>().and_then(Option::take)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_comes_back_as_its_own_type_alone() {
        assert_eq!(same::<_, Vec<f64>>(vec![1.5]), Some(vec![1.5]));
        assert_eq!(same::<_, Vec<f32>>(vec![1.5]), None);
    }
}

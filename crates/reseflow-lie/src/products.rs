//! The group product `*` for owned and borrowed operands, written once for every group.

use crate::{SE3, SO3};
use std::ops::Mul;

macro_rules! group_product {
    ($group:ty) => {
        impl Mul<$group> for $group {
            type Output = $group;
            fn mul(self, right: $group) -> $group {
                self.compose(&right)
            }
        }
        impl Mul<&$group> for $group {
            type Output = $group;
            fn mul(self, right: &$group) -> $group {
                self.compose(right)
            }
        }
        impl Mul<$group> for &$group {
            type Output = $group;
            fn mul(self, right: $group) -> $group {
                self.compose(&right)
            }
        }
        impl Mul<&$group> for &$group {
            type Output = $group;
            fn mul(self, right: &$group) -> $group {
                self.compose(right)
            }
        }
    };
}

group_product!(SO3);
group_product!(SE3);

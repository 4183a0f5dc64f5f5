//! End-to-end tests over the whole workspace, in this folder's test target; the library itself is empty.

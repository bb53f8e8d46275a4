//! `immersa schema`: the scene format for editors.

use crate::base::Result;
use crate::scene::json_schema;

pub(super) fn schema() -> Result<()> {
    super::print(&json_schema())
}

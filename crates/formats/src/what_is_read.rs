//! What is read of each format, as plain data: the tables that the readers themselves use.

use crate::{cameras, fspy, gltf, ies, import, materialx, merl, obj, picture};

pub use crate::entry::{Row, Table, Taken};

/// The tables of all formats.
///
/// ```
/// use unrender_formats::what_is_read::{Taken, what_is_read};
///
/// let tables = what_is_read();
/// let obj = tables.iter().find(|table| table.title == "OBJ").unwrap();
/// let row = obj.rows.iter().find(|row| row.element == "vn").unwrap();
/// assert_eq!((row.taken, row.done), (Taken::Read, "a normal"));
/// ```
pub fn what_is_read() -> Vec<Table> {
    let mut tables = [obj::tables(), gltf::tables(), import::tables(), picture::tables()].concat();
    tables.extend(cameras::tables());
    tables.push(fspy::table());
    tables.push(ies::table_of_elements());
    tables.push(merl::table());
    tables.extend(materialx::tables());
    tables
}

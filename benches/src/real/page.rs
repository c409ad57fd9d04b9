//! Writes `real.md`: how to fetch the photographs, and a section per case.

use super::Case;
use crate::{Failure, machine, page};
use clap::ValueEnum;
use std::path::Path;
use unrender::formats::atomic;

const FILE: &str = "real.md";

const HEAD: &str = "# Real photographs

Recoveries from photographs that were not rendered, and of one hard synthetic case. The photographs
belong to others: whoever runs this fetches them, as they are not part of the repository.

| case | where | licence | option |
|---|---|---|---|
| `ball` | <https://github.com/yqueau/robust_ps> at commit 86a1fbe, folder `Datasets/Ball_DiliGenT` (DiLiGenT, Shi et al. 2016) | none stated; later commits removed the photographs for copyright reasons | `--ball DIR` or `UNRENDER_BALL` |
| `gray` | <https://github.com/NewProggie/Photometric-Stereo> at commit b7b837a, folder `images` | MIT for the repository, whose author states that the photographs are not his | `--gray DIR` or `UNRENDER_GRAY` |
| `iset` | photographs of Stanford ISET's box (arXiv 2201.07411), with a scene fitted to each (not published) and the measured ratios in `truth.json` | none stated | `--iset DIR` or `UNRENDER_ISET` |
| `wall` | made by the command | | |

```console
git clone https://github.com/yqueau/robust_ps
git -C robust_ps checkout 86a1fbe
git clone https://github.com/NewProggie/Photometric-Stereo
cargo run --release -p unrender-benches -- real --ball robust_ps/Datasets/Ball_DiliGenT \\
    --gray Photometric-Stereo/images
```

A name (`real ball`) runs one case. `--prepare` writes the projects and stops; `--score` scores the
`result` folder beside each project; what follows `--` goes to `unrender recover`. This page is
written by the command.
";

/// Writes the section of the case called `name` into the page in `folder`, with the machine and version
/// below its heading.
///
/// # Errors
/// If it cannot be written.
pub(super) fn write(folder: &Path, name: &str, text: &str) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    let path = folder.join(FILE);
    let before = std::fs::read_to_string(&path).unwrap_or_default();
    let names: Vec<String> =
        Case::value_variants().iter().map(|case| case.name().to_owned()).collect();
    let (heading, rest) = text.split_once('\n').unwrap_or((text, ""));
    let text = format!("{heading}\n\n{}\n{rest}", machine::origin());
    Ok(atomic::write(&path, page::replace(HEAD, &before, &names, name, &text).as_bytes())?)
}

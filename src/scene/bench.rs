//! Reading `[bench]`: a scene as a work-precision study, that is, numbers of one of its points with what they should be, and
//! families of settings with which they are computed.
//!
//! ```toml
//! [bench]
//! point = "beat/UZ1"                    # where the numbers are read
//!
//! [bench.reference]                     # their names are those of [expect]
//! frequency = { value = 32.7133402, error = 1e-7, source = "..." }
//! "max tip_deflection" = { set = { "task.beat.degree" = 7 }, check = { "task.beat.degree" = 6 } }
//!
//! [[bench.family]]
//! name = "degree-4"
//! point = "motion/LC1"                  # where this family has the numbers, if elsewhere
//! set = { "task.beat.degree" = 4 }
//! vary = { "task.beat.intervals" = [5, 10, 20] }
//! ```
//!
//! Keys of `set`, `check` and `vary` are those of `--set`, or `model` for another model. A family has a setting for each
//! entry of the lists in `vary`, from coarse to fine; several lists go side by side.

use super::entry::{Entry, Section, Source};
use super::label::{self, Announced};
use super::overrides::Override;
use super::parse::{self, named_sections};
use super::tree::{Content, Table};
use super::{Expectation, Fault, Place, Scene, SceneError, Task};

/// `[bench]`.
#[derive(Clone, Debug)]
pub struct Bench {
    pub quantities: Vec<Quantity>,
    pub families: Vec<Family>,
}

/// A number whose error is measured.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// As in `[expect]`: a parameter or a value of the point.
    pub name: String,
    pub reference: Reference,
}

/// What a number should be.
#[derive(Clone, Debug)]
pub enum Reference {
    /// `{ value = 32.7133402, error = 1e-7, source = "..." }`: the error has the unit of the value.
    Known { value: f64, error: f64, source: String },
    /// `{ set = { ... }, check = { ... } }`: what the scene gives with the settings `set`; its error is the difference to
    /// what `check` gives, whose settings are laid over those of `set`.
    Computed { set: Box<Variant>, check: Box<Variant> },
}

/// `[[bench.family]]`.
#[derive(Clone, Debug)]
pub struct Family {
    pub name: String,
    /// From coarse to fine.
    pub variants: Vec<Variant>,
}

/// The scene with some of its values changed.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The point that has the numbers.
    pub point: String,
    /// Keys and values of what makes it this one, for people.
    pub changes: Vec<(String, String)>,
    /// Without figures; its expectations stand for the numbers wanted.
    pub scene: Scene,
}

const KEYS: [&str; 3] = ["point", "reference", "family"];
const FAMILY: [&str; 4] = ["name", "point", "set", "vary"];
const CHANGES: &str = "a table such as { \"model.functions\" = 32 }, with keys as those of --set";

/// What every variant of the study shares.
struct Base<'a> {
    source: &'a Source<'a>,
    /// The scene without what only a run of it as written needs.
    table: Table,
    quantities: Vec<(String, Place)>,
}

/// An entry of the scene to be changed, and where the study says so.
type Change<'a> = (Override, Entry<'a>);

pub(super) fn read(root: &Section<'_>, tasks: &[Task], announced: &[Announced]) -> Result<Option<Bench>, SceneError> {
    let Some(entry) = root.get("bench") else { return Ok(None) };
    let section = entry.section("a section, [bench]")?;
    section.allow("key of a study", &KEYS)?;
    let point = |section: &Section<'_>| -> Result<Option<String>, SceneError> {
        let Some(entry) = section.get("point") else { return Ok(None) };
        label::check(entry.text()?, tasks, announced).map_err(|fault| entry.error(fault))?;
        Ok(Some(entry.text()?.to_owned()))
    };
    section.need("point", "point = \"TASK/UZ1\", where the numbers are read")?;
    let own = point(&section)?.unwrap_or_default();
    let example = "[bench.reference] with QUANTITY = { value = NUMBER, error = NUMBER, source = \"...\" }";
    let references = section.need("reference", example)?.section("a section, [bench.reference]")?;
    let mut base = Base { source: root.source, table: root.table.clone(), quantities: Vec::new() };
    base.table.entries.retain(|(key, _)| !["figure", "expect", "bench"].contains(&key.as_str()));
    base.quantities = references.entries().map(|(name, entry)| (name.to_owned(), entry.at)).collect();
    if base.quantities.is_empty() {
        return Err(references.error(Fault::Empty { expected: "at least one quantity".to_owned() }));
    }
    let quantities = references
        .entries()
        .map(|(name, entry)| Ok(Quantity { name: name.to_owned(), reference: reference(&base, &entry, &own)? }))
        .collect::<Result<_, SceneError>>()?;
    let mut families = Vec::new();
    for (name, section) in named_sections(&section, "bench.family")? {
        section.allow("key of a family", &FAMILY)?;
        let point = point(&section)?.unwrap_or_else(|| own.clone());
        families.push(Family { name, variants: variants(&base, &section, &point)? });
    }
    if families.is_empty() {
        let (what, example) = ("a family".to_owned(), "[[bench.family]] with name and vary".to_owned());
        return Err(section.error(Fault::Missing { what, example }));
    }
    Ok(Some(Bench { quantities, families }))
}

fn reference(base: &Base<'_>, entry: &Entry<'_>, point: &str) -> Result<Reference, SceneError> {
    let section = entry.section("a table, { value = NUMBER, error = NUMBER } or { set = { ... }, check = { ... } }")?;
    if let Some(set) = section.get("set") {
        section.allow("key of a computed reference", &["set", "check"])?;
        let check = section.need("check", "check = { ... }, settings whose result differs by about the error")?;
        let (set, check) = (changes(&set)?, changes(&check)?);
        let both: Vec<&Change<'_>> = set.iter().chain(&check).collect();
        return Ok(Reference::Computed {
            set: Box::new(base.variant(&set.iter().collect::<Vec<_>>(), set.len(), point)?),
            check: Box::new(base.variant(&both, both.len(), point)?),
        });
    }
    section.allow("key of a reference", &["value", "error", "source", "set", "check"])?;
    let value = section.need("value", "value = NUMBER, or set = { ... } and check = { ... }")?.number()?;
    let error = section.need("error", "error = NUMBER, by how much the value may be wrong; 0 if it is exact")?;
    let source = section.need("source", "source = \"where the value comes from\"")?.text()?.to_owned();
    match error.number()? {
        bound if bound >= 0.0 => Ok(Reference::Known { value, error: bound, source }),
        bound => {
            let allowed = "0 or numbers greater than 0".to_owned();
            Err(error.error(Fault::OutOfBounds { found: bound.to_string(), allowed }))
        }
    }
}

/// The family's settings, one for each entry of its lists.
fn variants(base: &Base<'_>, section: &Section<'_>, point: &str) -> Result<Vec<Variant>, SceneError> {
    let fixed = match section.get("set") {
        Some(entry) => changes(&entry)?,
        None => Vec::new(),
    };
    let example = "vary = { \"model.functions\" = [8, 16, 32] }, from coarse to fine";
    let vary = section.need("vary", example)?;
    let table = vary.section("a table such as { \"model.functions\" = [8, 16, 32] }")?;
    let mut lists: Vec<Vec<Change<'_>>> = Vec::new();
    for (key, entry) in table.entries() {
        let items = entry.list("a list of values, from coarse to fine")?;
        if items.is_empty() {
            return Err(entry.error(Fault::Empty { expected: "at least one value, from coarse to fine".to_owned() }));
        }
        if let Some(first) = lists.first().filter(|first| first.len() != items.len()) {
            let allowed = format!("{} values, as many as in the list before it", first.len());
            return Err(entry.error(Fault::OutOfBounds { found: format!("a list of {}", items.len()), allowed }));
        }
        lists.push(items.into_iter().map(|item| change(key, item)).collect::<Result<_, _>>()?);
    }
    let Some(count) = lists.first().map(Vec::len) else {
        return Err(vary.error(Fault::Empty { expected: "at least one key, as in ".to_owned() + example }));
    };
    let variant = |k: usize| {
        let all: Vec<&Change<'_>> = fixed.iter().chain(lists.iter().map(|list| &list[k])).collect();
        base.variant(&all, lists.len(), point)
    };
    (0..count).map(variant).collect()
}

fn changes<'a>(entry: &Entry<'a>) -> Result<Vec<Change<'a>>, SceneError> {
    entry.section(CHANGES)?.entries().map(|(key, value)| change(key, value)).collect()
}

fn change<'a>(key: &str, value: Entry<'a>) -> Result<Change<'a>, SceneError> {
    if let ("model", Content::Table(model)) = (key, &value.node.content)
        && ["name", "equations"].iter().all(|key| model.get(key).is_none())
    {
        let message =
            "a model needs name or equations; an option of the present one is set by \"model.OPTION\", in quotes";
        return Err(value.error(Fault::Other(message.to_owned())));
    }
    match Override::entry(key, value.node) {
        Ok(change) => Ok((change, value)),
        Err(fault) => Err(value.error(fault)),
    }
}

impl Base<'_> {
    /// The scene with all changes; the last `named` of them name it.
    fn variant(&self, changes: &[&Change<'_>], named: usize, point: &str) -> Result<Variant, SceneError> {
        let mut table = self.table.clone();
        for (change, entry) in changes {
            change.apply(&mut table).map_err(|fault| entry.error(fault))?;
        }
        let root = Section { source: self.source, table: &table, at: Place::default() };
        let mut scene = parse::read(&root, false)?;
        scene.expect = self.quantities.iter().map(|(quantity, at)| wanted(point, quantity, at)).collect();
        let mut names: Vec<(String, String)> = Vec::new();
        for (key, value) in changes.iter().skip(changes.len() - named).map(|(change, _)| change.words()) {
            names.retain(|(known, _)| *known != key);
            names.push((key, value));
        }
        Ok(Variant { point: point.to_owned(), changes: names, scene })
    }
}

/// An expectation without a value: the run computes what it names.
fn wanted(point: &str, quantity: &str, at: &Place) -> Expectation {
    Expectation {
        label: point.to_owned(),
        quantity: quantity.to_owned(),
        value: f64::NAN,
        tolerance: f64::INFINITY,
        source: String::new(),
        at: at.clone(),
    }
}

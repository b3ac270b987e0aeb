//! Where the symbols stand and the wires run. Whole pixels, so that equal programs give equal
//! drawings.

use std::collections::{BTreeMap, BTreeSet};

use super::symbols::{CHAR_PX, Node, STUB_PX, pixels};
use crate::{N_RESOURCES, ResourceId};

/// A wire that would cross more layers than this becomes a name at both ends.
const WIRE_LAYERS_MAX: usize = 4;
/// Between two symbols of a layer, px.
const ROW_GAP_PX: i32 = 20;
/// Height of a row that only holds a wire, px.
const WIRE_ROW_PX: i32 = 20;
/// Between two vertical tracks, px.
const TRACK_PX: i32 = 10;
const MARGIN_PX: i32 = 20;

/// An output of a node: index of the node, index of the output.
pub(super) type Net = (usize, usize);

/// A node in its place.
#[derive(Debug)]
pub(super) struct Placed {
    pub(super) node: Node,
    /// Left edge, px.
    pub(super) x: i32,
    /// Upper edge, px.
    pub(super) y: i32,
    /// For every input: whether a wire comes.
    pub(super) is_wired: Vec<bool>,
}

/// A piece of wire: corners in px.
#[derive(Debug)]
pub(super) struct Wire {
    pub(super) id: ResourceId,
    pub(super) corners: Vec<(i32, i32)>,
    /// Where it branches.
    pub(super) dots: Vec<(i32, i32)>,
}

#[derive(Debug)]
pub(super) struct Drawing {
    pub(super) nodes: Vec<Placed>,
    pub(super) wires: Vec<Wire>,
    /// px.
    pub(super) width: i32,
    /// px.
    pub(super) height: i32,
}

/// What takes room in a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Item {
    Node(usize),
    Through(Net),
}

/// What a net has to reach on the right of a gap.
#[derive(Debug, Default)]
struct Run {
    source_y: i32,
    targets: Vec<i32>,
}

struct Layout {
    nodes: Vec<Placed>,
    layer_of: Vec<usize>,
    /// For every node, for every input: the net that drives it in the same scan.
    drivers: Vec<Vec<Option<Net>>>,
    layers: Vec<Vec<Item>>,
    /// Height of a net's row in each layer that it only passes, px.
    rows: BTreeMap<(usize, Net), i32>,
    wires: Vec<Wire>,
}

pub(super) fn lay_out(nodes: Vec<Node>) -> Drawing {
    let (drivers, layer_of) = connect(&nodes);
    let place = |(node, drivers): (Node, &Vec<Option<Net>>)| {
        let is_wired = drivers.iter().map(Option::is_some).collect();
        Placed { node, x: 0, y: 0, is_wired }
    };
    let nodes: Vec<Placed> = nodes.into_iter().zip(&drivers).map(place).collect();
    let (layers, rows, wires) = (Vec::new(), BTreeMap::new(), Vec::new());
    let mut layout = Layout { nodes, layer_of, drivers, layers, rows, wires };
    layout.fill_layers();
    let mut x = MARGIN_PX;
    let mut height = 0;
    for layer in 0..layout.layers.len() {
        height = height.max(layout.place_rows(layer));
        x = layout.place_columns(layer, x);
    }
    Drawing {
        nodes: layout.nodes,
        wires: layout.wires,
        width: x.saturating_add(MARGIN_PX),
        height: height.saturating_add(MARGIN_PX),
    }
}

/// Finds the writer of every input among the functions above it, and the layer of every node:
/// one more than its writers'. Far writers are dropped in the end: names will do.
fn connect(nodes: &[Node]) -> (Vec<Vec<Option<Net>>>, Vec<usize>) {
    let mut writer: Vec<Option<Net>> = vec![None; usize::from(N_RESOURCES)];
    let mut drivers: Vec<Vec<Option<Net>>> = Vec::with_capacity(nodes.len());
    let mut layer_of: Vec<usize> = Vec::with_capacity(nodes.len());
    for (index, node) in nodes.iter().enumerate() {
        let find = |id: ResourceId| writer.get(usize::from(id.address())).copied().flatten();
        let found: Vec<Option<Net>> = node.inputs.iter().map(|pin| find(pin.id)).collect();
        let behind = |net: &Net| layer_of.get(net.0).map_or(0, |layer| layer.saturating_add(1));
        let layer = found.iter().flatten().map(behind).max().unwrap_or(0);
        let near = |net: Net| layer <= behind(&net).saturating_add(WIRE_LAYERS_MAX);
        drivers.push(found.into_iter().map(|net| net.filter(|&net| near(net))).collect());
        layer_of.push(layer);
        for (output, pin) in node.outputs.iter().enumerate() {
            if let Some(slot) = writer.get_mut(usize::from(pin.id.address())) {
                *slot = Some((index, output));
            }
        }
    }
    (drivers, layer_of)
}

impl Layout {
    /// Puts every node into its layer, and every net into the layers that it passes.
    fn fill_layers(&mut self) {
        let n_layers = self.layer_of.iter().max().map_or(0, |layer| layer.saturating_add(1));
        self.layers = vec![Vec::new(); n_layers];
        let mut passing = BTreeSet::new();
        for (index, (&layer, drivers)) in self.layer_of.iter().zip(&self.drivers).enumerate() {
            if let Some(items) = self.layers.get_mut(layer) {
                items.push(Item::Node(index));
            }
            for &net in drivers.iter().flatten() {
                let from = self.layer_of.get(net.0).map_or(0, |layer| layer.saturating_add(1));
                passing.extend((from..layer).map(|between| (between, net)));
            }
        }
        for (layer, net) in passing {
            if let Some(items) = self.layers.get_mut(layer) {
                items.push(Item::Through(net));
            }
        }
    }

    /// Height of a net where it leaves a layer, px.
    fn net_y(&self, layer: usize, net: Net) -> i32 {
        if let Some(&y) = self.rows.get(&(layer, net)) {
            return y;
        }
        let placed = self.nodes.get(net.0);
        let pin = placed.and_then(|placed| placed.node.outputs.get(net.1));
        placed.map_or(0, |placed| placed.y).saturating_add(pin.map_or(0, |pin| pin.y))
    }

    /// Where an item's upper edge must be for its first wire to be straight.
    fn wished_y(&self, layer: usize, item: Item) -> Option<i32> {
        let before = layer.checked_sub(1)?;
        match item {
            Item::Through(net) => Some(self.net_y(before, net).saturating_sub(WIRE_ROW_PX / 2)),
            Item::Node(index) => {
                let pins = self.nodes.get(index)?.node.inputs.iter();
                let mut wired = pins.zip(self.drivers.get(index)?);
                let (pin, net) = wired.find_map(|(pin, net)| Some((pin, (*net)?)))?;
                Some(self.net_y(before, net).saturating_sub(pin.y))
            }
        }
    }

    /// Places the items of a layer one below the other; gives the lower edge of the last.
    fn place_rows(&mut self, layer: usize) -> i32 {
        let mut items = self.layers.get(layer).cloned().unwrap_or_default();
        let mut wishes: Vec<(Option<i32>, Item)> =
            items.drain(..).map(|item| (self.wished_y(layer, item), item)).collect();
        // Stable: without a wish, and among equal ones, the order of the program.
        wishes.sort_by_key(|&(wish, _)| wish.unwrap_or(0));
        let mut next_free = MARGIN_PX;
        for (wish, item) in wishes {
            let y = wish.unwrap_or(next_free).max(next_free);
            let height = match item {
                Item::Through(net) => {
                    self.rows.insert((layer, net), y.saturating_add(WIRE_ROW_PX / 2));
                    WIRE_ROW_PX
                }
                Item::Node(index) => self.nodes.get_mut(index).map_or(0, |placed| {
                    placed.y = y;
                    placed.node.height.saturating_add(ROW_GAP_PX)
                }),
            };
            next_free = y.saturating_add(height);
        }
        next_free
    }

    /// Draws the wires that arrive at a layer, and gives the x of its right edge with the names
    /// of its outputs. `x` is where the layer before ends.
    fn place_columns(&mut self, layer: usize, x: i32) -> i32 {
        let runs = self.runs(layer);
        let tracks = order_tracks(&runs);
        let indices: Vec<usize> = self.node_indices(layer);
        let nodes = || indices.iter().filter_map(|&index| self.nodes.get(index));
        let name = |label: &str| pixels(label.chars().count()).saturating_mul(CHAR_PX);
        let unwired = nodes().flat_map(|p| p.node.inputs.iter().zip(&p.is_wired));
        let names = unwired.filter(|(_, wired)| !**wired).map(|(pin, _)| name(&pin.label)).max();
        let outputs = nodes().flat_map(|p| &p.node.outputs).map(|pin| name(&pin.label)).max();
        let width = nodes().map(|p| p.node.width).max().unwrap_or(0);

        let first_track = x.saturating_add(TRACK_PX);
        let tracks_end = first_track.saturating_add(pixels(tracks.len()).saturating_mul(TRACK_PX));
        let left = tracks_end.saturating_add(names.unwrap_or(0)).saturating_add(14);
        let right = left.saturating_add(width);
        let end = right.saturating_add(outputs.unwrap_or(0)).saturating_add(24);

        for (&net, run) in &runs {
            let track = tracks.iter().position(|&other| other == net).map_or(0, pixels);
            let track_x = first_track.saturating_add(track.saturating_mul(TRACK_PX));
            self.draw_run(net, run, [self.start_x(layer, net, x), track_x, left]);
        }
        self.draw_passing(layer, [left, end]);
        for index in indices {
            if let Some(placed) = self.nodes.get_mut(index) {
                placed.x = left;
            }
        }
        end
    }

    fn node_indices(&self, layer: usize) -> Vec<usize> {
        let items = self.layers.get(layer).into_iter().flatten();
        let index = |item: &Item| match *item {
            Item::Node(index) => Some(index),
            Item::Through(_) => None,
        };
        items.filter_map(index).collect()
    }

    /// Where a net begins before the gap to the left of `layer`: at its symbol, or where its row
    /// through the layer before has ended.
    fn start_x(&self, layer: usize, net: Net, x: i32) -> i32 {
        let starts_here =
            self.layer_of.get(net.0).map(|from| from.saturating_add(1)) == Some(layer);
        let placed = self.nodes.get(net.0).filter(|_| starts_here);
        placed
            .map_or(x, |placed| placed.x.saturating_add(placed.node.width).saturating_add(STUB_PX))
    }

    /// Every net that arrives at a layer, and where it must go.
    fn runs(&self, layer: usize) -> BTreeMap<Net, Run> {
        let mut runs: BTreeMap<Net, Run> = BTreeMap::new();
        let Some(before) = layer.checked_sub(1) else { return runs };
        let mut add = |net: Net, y: i32| {
            let source_y = self.net_y(before, net);
            let run = runs.entry(net).or_insert(Run { source_y, targets: Vec::new() });
            run.targets.push(y);
        };
        for &item in self.layers.get(layer).into_iter().flatten() {
            match item {
                Item::Through(net) => add(net, self.net_y(layer, net)),
                Item::Node(index) => {
                    let Some(placed) = self.nodes.get(index) else { continue };
                    let drivers = self.drivers.get(index).into_iter().flatten();
                    for (pin, net) in placed.node.inputs.iter().zip(drivers) {
                        if let Some(net) = *net {
                            add(net, placed.y.saturating_add(pin.y));
                        }
                    }
                }
            }
        }
        runs
    }

    fn draw_run(&mut self, net: Net, run: &Run, [start_x, track_x, end_x]: [i32; 3]) {
        let Some(id) = self.nodes.get(net.0).and_then(|p| p.node.outputs.get(net.1)).map(|p| p.id)
        else {
            return;
        };
        let heights = run.targets.iter().chain([&run.source_y]);
        let (low, high) = (heights.clone().min().copied(), heights.max().copied());
        for &y in &run.targets {
            let inside = |y: i32| Some(y) > low && Some(y) < high;
            let branches = [run.source_y, y].into_iter().filter(|&y| inside(y));
            let dots = branches.map(|y| (track_x, y)).collect();
            let corners =
                vec![(start_x, run.source_y), (track_x, run.source_y), (track_x, y), (end_x, y)];
            self.wires.push(Wire { id, corners, dots });
        }
    }

    /// The rows of a layer that only hold a wire.
    fn draw_passing(&mut self, layer: usize, [left, right]: [i32; 2]) {
        for &item in self.layers.get(layer).into_iter().flatten() {
            let Item::Through(net) = item else { continue };
            let y = self.net_y(layer, net);
            let pin = self.nodes.get(net.0).and_then(|p| p.node.outputs.get(net.1));
            if let Some(id) = pin.map(|pin| pin.id) {
                let corners = vec![(left, y), (right, y)];
                self.wires.push(Wire { id, corners, dots: Vec::new() });
            }
        }
    }
}

/// The nets that need a vertical track, from left to right. When one net leaves at the height at
/// which another arrives, the leaving one must turn first, or the two would lie on each other.
fn order_tracks(runs: &BTreeMap<Net, Run>) -> Vec<Net> {
    let bends = |run: &Run| run.targets.iter().any(|&y| y != run.source_y);
    let mut waiting: Vec<(Net, &Run)> =
        runs.iter().filter(|(_, run)| bends(run)).map(|(&net, run)| (net, run)).collect();
    let mut order = Vec::with_capacity(waiting.len());
    while !waiting.is_empty() {
        let must_wait = |&(net, run): &(Net, &Run)| {
            let mut others = waiting.iter().filter(|&&(other, _)| other != net);
            others.any(|(_, other)| run.targets.contains(&other.source_y))
        };
        // If all wait for each other, one of them has to begin: two wires will touch.
        let index = waiting.iter().position(|net| !must_wait(net)).unwrap_or(0);
        order.push(waiting.remove(index).0);
    }
    order
}

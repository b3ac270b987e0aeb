//! In which order scans were taken, where the stamps of a file contradict its lines.
//!
//! Source: none; the rule is ours. Three orders are compared: that of the stamps, that of the stamps within the parts
//! between two settings of the clock, and that of the file. The one is taken in which the odometry travels
//! least, and of equally good ones the first. Then the stamps are made to ascend.

use crate::{
    complaints::{Action, Complaints, Place, Trouble},
    numbers::decimal_from_nanos,
    raw::RawScan,
};

/// How far ahead a stamp that jumps back is followed, in scans, to see whether the clock was set.
const LOOK_AHEAD: usize = 10;
/// How many scans before it are compared.
const LOOK_BACK: usize = 3;
/// Metres that a radian of turning counts as when orders are compared.
const M_PER_RAD: f64 = 0.5;
/// A range that changes by more than this counts as this, metres.
const RANGE_CHANGE_MAX_M: f64 = 1.0;

/// From this line on, so many nanoseconds are added to the stamps of the file.
pub(crate) type Shift = (Place, i64);

/// Puts scans in order and their stamps in ascending order; returns how the clock was mended.
pub(crate) fn put_in_order(scans: &mut Vec<RawScan>, complaints: &mut Complaints) -> Vec<Shift> {
    if scans.is_sorted_by_key(|s| s.stamp_ns) {
        return Vec::new();
    }
    let in_file: Vec<usize> = (0..scans.len()).collect();
    let mut sorted = in_file.clone();
    sorted.sort_by_key(|&i| (scans[i].stamp_ns, i));
    let resets = resets(scans);
    let mut parts = in_file.clone();
    for bounds in bounds(&resets, scans.len()).windows(2) {
        parts[bounds[0]..bounds[1]].sort_by_key(|&i| (scans[i].stamp_ns, i));
    }
    // Of equally good ones the first: time decides where the odometry does not.
    let orders = [sorted, parts, in_file];
    let travels: Vec<f64> = orders.iter().map(|order| travel_m(scans, order)).collect();
    let mut best = 0;
    for (index, travel) in travels.iter().enumerate() {
        if *travel < travels[best] * (1.0 - 1e-9) {
            best = index;
        }
    }
    if best == 0 {
        complain_out_of_order(scans, &orders[0], complaints);
        apply(scans, &orders[0]);
        return Vec::new();
    }
    if best == 1 {
        complain_out_of_order(scans, &orders[1], complaints);
    }
    apply(scans, &orders[best]);
    let shifts = join_parts(scans, &resets, complaints);
    straighten(scans, complaints);
    shifts
}

/// Where the clock was set back: every one of the next stamps lies before every one of the last ones.
fn resets(scans: &[RawScan]) -> Vec<usize> {
    let stamp = |s: &RawScan| s.stamp_ns;
    let is_reset = |&i: &usize| {
        let before = scans[i.saturating_sub(LOOK_BACK)..i].iter().map(stamp).min();
        let after = scans[i..scans.len().min(i + LOOK_AHEAD)].iter().map(stamp).max();
        // One stray stamp at the very end is no new clock.
        i + 1 < scans.len() && after < before
    };
    (1..scans.len()).filter(is_reset).collect()
}

fn bounds(resets: &[usize], n: usize) -> Vec<usize> {
    [&[0], resets, &[n]].concat()
}

/// How far the odometry travels in this order, metres (turns too); without odometry how much ranges change.
fn travel_m(scans: &[RawScan], order: &[usize]) -> f64 {
    let step = |w: &[usize]| {
        let (a, b) = (&scans[w[0]], &scans[w[1]]);
        match (a.odom, b.odom) {
            (Some(a), Some(b)) => {
                let turn = geometry::wrap_to_pi(b.yaw_rad - a.yaw_rad).abs();
                (b.position() - a.position()).norm() + M_PER_RAD * turn
            }
            _ => range_change_m(&a.ranges_m, &b.ranges_m),
        }
    };
    order.windows(2).map(step).sum()
}

fn range_change_m(a: &[f64], b: &[f64]) -> f64 {
    let change = |(a, b): (&f64, &f64)| {
        // Two infinite ranges differ by NaN; they have not changed.
        let difference = (a - b).abs();
        if difference.is_nan() { 0.0 } else { difference.min(RANGE_CHANGE_MAX_M) }
    };
    a.iter().zip(b).map(change).sum::<f64>() / a.len().max(1) as f64
}

fn apply(scans: &mut Vec<RawScan>, order: &[usize]) {
    let mut taken: Vec<Option<RawScan>> = scans.drain(..).map(Some).collect();
    scans.extend(order.iter().filter_map(|&i| taken[i].take()));
}

/// One complaint for each scan that stands after a later one in the file and not in the order.
fn complain_out_of_order(scans: &[RawScan], order: &[usize], complaints: &mut Complaints) {
    let mut place = vec![0; scans.len()];
    for (position, &index) in order.iter().enumerate() {
        place[index] = position;
    }
    let mut latest = 0;
    for index in 1..scans.len() {
        if place[index] > place[latest] {
            latest = index;
            continue;
        }
        let (now, before) = (scans[index].stamp_ns, scans[latest].stamp_ns);
        let text = || {
            let (now, before) = (decimal_from_nanos(now), decimal_from_nanos(before));
            format!("stamp {now} s after {before} s; sorted into its place")
        };
        complaints.add(scans[index].place, Trouble::OutOfOrder, Action::Repaired, text);
    }
}

/// Lets time go on where the clock was set back.
fn join_parts(scans: &mut [RawScan], resets: &[usize], complaints: &mut Complaints) -> Vec<Shift> {
    let period = usual_period_ns(scans);
    let mut shifts: Vec<Shift> = Vec::new();
    let bounds = bounds(resets, scans.len());
    for part in bounds[1..].windows(2) {
        let (before, rest) = scans.split_at_mut(part[0]);
        let length = part[1] - part[0];
        let (Some(last), Some(first)) = (before.last(), rest.first()) else { continue };
        let (last_ns, first_ns, place) = (last.stamp_ns, first.stamp_ns, first.place);
        let shift = last_ns.saturating_add(period).saturating_sub(first_ns);
        let text = || {
            let old_shift = shifts.last().map_or(0, |s| s.1);
            let file_before = decimal_from_nanos(last_ns.saturating_sub(old_shift));
            let (now, by) = (decimal_from_nanos(first_ns), decimal_from_nanos(shift));
            format!(
                "stamp {now} s after {file_before} s: the clock was set; from here on {by} s are added"
            )
        };
        complaints.add(place, Trouble::StampJumpsBack, Action::Repaired, text);
        for scan in &mut rest[..length] {
            move_scan(scan, shift);
        }
        shifts.push((place, shift));
    }
    shifts
}

/// Gives scans whose stamps fit into no ascending row the stamp of the scan before. The fewest possible are
/// changed: the longest ascending row is kept.
fn straighten(scans: &mut [RawScan], complaints: &mut Complaints) {
    let good = longest_ascending(&scans.iter().map(|s| s.stamp_ns).collect::<Vec<_>>());
    let Some(first_good) = good.iter().position(|&g| g) else { return };
    let mut last_ns = scans[first_good].stamp_ns;
    for (scan, is_good) in scans.iter_mut().zip(good) {
        if is_good {
            last_ns = scan.stamp_ns;
            continue;
        }
        let was = scan.stamp_ns;
        let text = || {
            let (was, now) = (decimal_from_nanos(was), decimal_from_nanos(last_ns));
            format!("stamp {was} s does not fit between those around it; {now} s is taken")
        };
        complaints.add(scan.place, Trouble::StampJumpsBack, Action::Repaired, text);
        move_scan(scan, last_ns.saturating_sub(was));
        scan.stamp_ns = last_ns;
    }
}

fn move_scan(scan: &mut RawScan, shift: i64) {
    scan.stamp_ns = scan.stamp_ns.saturating_add(shift);
    for stamp in &mut scan.stamps_ns {
        *stamp = stamp.saturating_add(shift);
    }
}

/// Which values belong to the longest row that never descends. O(n log n).
pub(crate) fn longest_ascending(values: &[i64]) -> Vec<bool> {
    // tails[k]: index of the smallest value that ends a row of k + 1.
    let mut tails: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = vec![None; values.len()];
    for (index, value) in values.iter().enumerate() {
        let at = tails.partition_point(|&t| values[t] <= *value);
        before[index] = at.checked_sub(1).map(|k| tails[k]);
        if at == tails.len() {
            tails.push(index);
        } else {
            tails[at] = index;
        }
    }
    let mut chosen = vec![false; values.len()];
    let mut next = tails.last().copied();
    while let Some(index) = next {
        chosen[index] = true;
        next = before[index];
    }
    chosen
}

/// The median time between scans, of those that are later than the one before; a nanosecond without any.
fn usual_period_ns(scans: &[RawScan]) -> i64 {
    let gap = |w: &[RawScan]| w[1].stamp_ns.saturating_sub(w[0].stamp_ns);
    let mut gaps: Vec<i64> = scans.windows(2).map(gap).filter(|&g| g > 0).collect();
    gaps.sort_unstable();
    gaps.get(gaps.len() / 2).copied().unwrap_or(1)
}

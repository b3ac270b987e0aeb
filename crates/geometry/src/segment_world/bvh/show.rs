//! Everything that may be in sight within a cone, nearest boxes first.

use super::{Bvh, Child, Leads, STACK_SIZE};
use crate::cone::ConeView;

impl Bvh {
    /// Offers the walls and blocks whose boxes reach into the cone and are not behind its front.
    pub(in super::super) fn show(&self, view: &mut ConeView) {
        if self.boxes.is_empty() {
            return;
        }
        let bounds = self.parts.bounds;
        let middle = bounds.centre();
        let coarse = view.coarse(middle, 0.5 * bounds.size().max());
        let mut waiting = [(0.0_f32, Child::ROOT); STACK_SIZE];
        let mut n_waiting = 1;
        while n_waiting > 0 {
            n_waiting -= 1;
            let (depth_m, child) = waiting[n_waiting];
            if f64::from(depth_m) > view.depth_limit_m() {
                continue;
            }
            match child.leads() {
                Leads::ToNode(node) => {
                    let floor = n_waiting;
                    let depths = coarse.depths(&self.boxes[node].0);
                    let children = &self.links[node].children;
                    for (depth_m, &child) in depths.into_iter().zip(children) {
                        // Unused lanes have empty boxes, whose depth is no number.
                        let reaches = f64::from(depth_m) <= view.depth_limit_m();
                        if !reaches {
                            continue;
                        }
                        // Sorted in, so that the nearest of the four is on top.
                        let mut place = n_waiting;
                        while place > floor && waiting[place - 1].0 < depth_m {
                            waiting[place] = waiting[place - 1];
                            place -= 1;
                        }
                        waiting[place] = (depth_m, child);
                        n_waiting += 1;
                    }
                }
                Leads::ToWall(place) => {
                    let wall = &self.parts.walls[place];
                    view.offer_segment(wall.segment, wall.tag);
                }
                Leads::ToBlock(place) => {
                    let block = &self.parts.blocks[place];
                    view.offer_box(block.bounds, block.tag);
                }
                Leads::Nowhere => {}
            }
        }
    }
}

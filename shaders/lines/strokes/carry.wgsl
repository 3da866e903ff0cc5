// Strokes take over what was there: who they are, where on their texture they are, how hard the pen is pressed, and a
// part of the place.
//
// - Identity: of the chains that continue the same stroke, the one that has most of it; the others are new.
// - Parameter: arc length plus the offset that the samples voted for, plus what is left of each sample's own difference
//   (`SLACK`, so that perspective and bends do not make the texture slide), which slowly goes to nothing.
// - Pressure: from what it was toward its goal, by a bounded step. New strokes begin at nothing.
// - Place: the line is held where it was, as far as the style says, but never more than HELD_PX from where it is.
#import hachure::view::{View, ray_at}
#import hachure::strokes::{Chain, StrokeCounts}
#import hachure::stroke_samples::{Carry, Heritage, Match, Sample, CLAIMS, hash}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> carry: Carry;
@group(0) @binding(2) var<storage, read> counts: StrokeCounts;
@group(0) @binding(3) var<storage, read> chains: array<Chain>;
@group(0) @binding(4) var<storage, read> starts: array<u32>;
@group(0) @binding(5) var<storage, read> matches: array<Match>;
@group(0) @binding(6) var<storage, read> heritages: array<Heritage>;
@group(0) @binding(7) var<storage, read> claims: array<u32>;
@group(0) @binding(8) var<storage, read_write> samples: array<Sample>;
// SampleCounts: the second number is of those of chains, the fifth of strokes that took over.
@group(0) @binding(9) var<storage, read_write> list: array<atomic<u32>>;

const SLACK_PX: f32 = 12.0;
const SLACK_KEPT: f32 = 0.97;
const HELD_PX: f32 = 1.25;
const WIDTH_KEPT: f32 = 0.7;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let fresh = atomicLoad(&list[1]);
    if id.x >= fresh {
        return;
    }
    var own = samples[id.x];
    let number = own.stroke;
    let chain = chains[number];
    let first = starts[number];
    let end = min(select(fresh, starts[number + 1u], number + 1u < counts.chains), fresh);
    // The same stroke gets the same number in the same view, whatever order chains were found in.
    let name = hash(chain.key ^ hash(chain.length_units)) ^ hash(carry.seed);
    var stroke = max(name, 1u);
    var along_px = own.along_px + f32(hash(name) & 1023u);
    if carry.has_history == 1u {
        let heritage = heritages[number];
        if heritage.stroke != 0u {
            if claims[hash(heritage.stroke) % CLAIMS] == heritage.claim {
                stroke = heritage.stroke;
                if id.x == first {
                    atomicAdd(&list[4], 1u);
                }
            }
            along_px = heritage.sense * own.along_px + heritage.offset_px;
        }
        // Of the sample and those beside it.
        var pressure = 0.0;
        var slack_px = 0.0;
        var slacks = 0.0;
        var toward_px = vec2<f32>(0.0);
        var towards = 0.0;
        for (var i = max(id.x, first + 2u) - 2u; i < min(id.x + 3u, end); i++) {
            let beside = matches[i];
            let weight = select(0.5, 1.0, i == id.x);
            let is_next = max(i, id.x) - min(i, id.x) <= 1u;
            if beside.stroke == 0u {
                continue;
            }
            if is_next {
                pressure = max(pressure, beside.pressure);
            }
            toward_px += weight * beside.toward_px;
            towards += weight;
            let there_px = heritage.sense * beside.at_px + heritage.offset_px;
            let difference = beside.along_px - there_px;
            if beside.stroke == heritage.stroke && beside.sense == heritage.sense && abs(difference) <= SLACK_PX {
                slack_px += weight * difference;
                slacks += weight;
            }
        }
        along_px += SLACK_KEPT * slack_px / max(slacks, 1.0);
        own.pressure = pressure + clamp(own.goal - pressure, -carry.pressure_step, carry.pressure_step);
        if matches[id.x].stroke != 0u {
            own.half_width_px = mix(own.half_width_px, matches[id.x].half_width_px, WIDTH_KEPT);
        }
        if towards > 0.0 {
            let toward = toward_px / towards * carry.hold;
            own.px += toward * min(1.0, HELD_PX / max(length(toward), 1e-6));
            own.position_m = ray_at(view, own.px) * own.depth_m;
        }
    }
    own.stroke = stroke;
    own.along_px = along_px;
    samples[id.x] = own;
}

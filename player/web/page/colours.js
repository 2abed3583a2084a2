// Colour scales of the maps: stops on [0, 1], interpolated linearly.

/// Viridis (van der Walt and Smith 2015), nine stops: increasing lightness, safe for colour-blind viewers and print.
const viridis = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];
/// Blue, white, orange: diverging, for differences about zero.
const diverging = [[11, 76, 140], [98, 160, 212], [246, 246, 244], [240, 164, 105], [170, 66, 6]];

function between(stops, s) {
  const at = Math.min(Math.max(s, 0), 1) * (stops.length - 1), k = Math.min(Math.floor(at), stops.length - 2);
  return stops[k].map((x, c) => Math.round(x + (at - k) * (stops[k + 1][c] - x)));
}

export const scales = {
  value: (s) => between(viridis, s),
  difference: (s) => between(diverging, s),
};

/// The statuses of attitudes in the order of their codes.
export const statuses = [
  { code: -1, label: "pending", colour: [190, 196, 203] },
  { code: 0, label: "solved", colour: [55, 140, 98] },
  { code: 1, label: "no contact", colour: [230, 159, 0] },
  { code: 2, label: "no clearance", colour: [204, 121, 167] },
  { code: 3, label: "iteration limit", colour: [213, 94, 0] },
  { code: 4, label: "unbounded", colour: [86, 95, 180] },
];
/// Colour of a cell without a value.
export const empty = [222, 225, 229];

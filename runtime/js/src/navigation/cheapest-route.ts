/** Dijkstra's search over the eight neighbours of every cell. */

/**
 * The cheapest route through a grid of costs: a step costs its length times the mean of its two cells.
 * A diagonal one touches two more cells, at their corners; both must be open.
 *
 * @param costs Row by row; negative where no route may go.
 * @returns The cells from start to goal; null if there is no route.
 */
export function cheapestRoute(
  costs: Float64Array,
  columns: number,
  start: number,
  goal: number,
): number[] | null {
  const rows = costs.length / columns;
  const totals = new Float64Array(costs.length).fill(Infinity);
  const before = new Int32Array(costs.length).fill(-1);
  const done = new Uint8Array(costs.length);
  const queue = new Queue();
  if (!(costs[start] >= 0 && costs[goal] >= 0)) return null;
  totals[start] = 0;
  queue.push(start, 0);
  for (let cell = queue.pop(); cell !== undefined; cell = queue.pop()) {
    if (cell === goal) return traced(before, goal);
    if (done[cell]) continue;
    done[cell] = 1;
    const column = cell % columns;
    const row = (cell - column) / columns;
    for (let r = Math.max(0, row - 1); r <= Math.min(rows - 1, row + 1); r++) {
      for (let c = Math.max(0, column - 1); c <= Math.min(columns - 1, column + 1); c++) {
        const next = r * columns + c;
        if (done[next] || !(costs[next] >= 0)) continue;
        if (!(costs[row * columns + c] >= 0 && costs[r * columns + column] >= 0)) continue;
        const length = r !== row && c !== column ? Math.SQRT2 : 1;
        const total = totals[cell] + (length * (costs[cell] + costs[next])) / 2;
        if (total >= totals[next]) continue;
        totals[next] = total;
        before[next] = cell;
        queue.push(next, total);
      }
    }
  }
  return null;
}

function traced(before: Int32Array, goal: number): number[] {
  const route = [];
  for (let cell = goal; cell >= 0; cell = before[cell]) route.push(cell);
  return route.reverse();
}

/** A binary heap: the cell with the least total comes out first. */
class Queue {
  private readonly cells: number[] = [];
  private readonly totals: number[] = [];

  push(cell: number, total: number): void {
    let at = this.cells.length;
    while (at > 0) {
      const parent = (at - 1) >> 1;
      if (this.totals[parent] <= total) break;
      this.cells[at] = this.cells[parent];
      this.totals[at] = this.totals[parent];
      at = parent;
    }
    this.cells[at] = cell;
    this.totals[at] = total;
  }

  pop(): number | undefined {
    const first = this.cells[0];
    const cell = this.cells.pop();
    const total = this.totals.pop();
    if (cell === undefined || total === undefined || this.cells.length === 0) return first;
    const length = this.cells.length;
    let at = 0;
    for (;;) {
      let child = 2 * at + 1;
      if (child >= length) break;
      if (child + 1 < length && this.totals[child + 1] < this.totals[child]) child++;
      if (this.totals[child] >= total) break;
      this.cells[at] = this.cells[child];
      this.totals[at] = this.totals[child];
      at = child;
    }
    this.cells[at] = cell;
    this.totals[at] = total;
    return first;
  }
}

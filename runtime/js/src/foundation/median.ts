/** Medians by quickselect: a plane's fit takes hundreds of them. */

/** The median, the mean of the two middle values of an even number; NaN of none. Reorders `values`. */
export function median(values: Float64Array): number {
  const middle = values.length >> 1;
  const upper = select(values, middle);
  if (values.length % 2 === 1 || values.length === 0) return upper;
  let lower = -Infinity;
  for (let i = 0; i < middle; i++) if (values[i] > lower) lower = values[i];
  return (lower + upper) / 2;
}

/** The value that would stand at `index` if all were in order; what is less moves before it. */
export function select(values: Float64Array, index: number): number {
  let from = 0;
  let to = values.length - 1;
  while (from < to) {
    const pivot = values[(from + to) >> 1];
    let i = from;
    let j = to;
    while (i <= j) {
      while (values[i] < pivot) i++;
      while (values[j] > pivot) j--;
      if (i > j) break;
      [values[i], values[j]] = [values[j], values[i]];
      i++;
      j--;
    }
    if (index <= j) to = j;
    else if (index >= i) from = i;
    else break;
  }
  return values.length > 0 ? values[index] : NaN;
}

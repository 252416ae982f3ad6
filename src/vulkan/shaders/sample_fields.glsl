// Fields of signed bytes over the samples of clusters.

// Four signed bytes, the lowest first.
vec4 signed_bytes(uint word) { return vec4(ivec4(uvec4(word << 24, word << 16, word << 8, word)) >> 24); }

uint field_words(FieldCluster cluster) { return (cluster.end_sample - cluster.first_sample + 3u) / 4u; }

// The last of the clusters whose first quad, or else first field, is not beyond the index.
uint cluster_of(FieldClusters clusters, uint count, uint index, bool of_quads) {
  uint first = 0u, end = count;
  while (end - first > 1u) {
    uint middle = (first + end) / 2u;
    uint begin = of_quads ? clusters.at[middle].first_quad : clusters.at[middle].first_field;
    if (begin <= index)
      first = middle;
    else
      end = middle;
  }
  return first;
}

// What both passes of the products of cuts read. Who includes this has defined `parameters`.

uint byte_at(Words values, uint index) {
  return bitfieldExtract(values.at[index >> 2], int(8u * (index & 3u)), 8);
}

uint base_value(uint piece) { return byte_at(parameters.product.base.values, piece); }

uint base_ends(uint receiver, uint word) {
  return parameters.product.base.masks.at[receiver * parameters.words + word];
}

// The ends of one of the factors' cuts.
uint factor_ends(uint cut, uint word) {
  return parameters.product.factors.masks.at[cut * parameters.words + word];
}

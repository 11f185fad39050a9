// A pass whose length is set by `iterations` and whose result depends on each of them.
uniform int iterations;
layout(location = 0) out vec4 out_value;

void main() {
  float x = gl_FragCoord.x * 0.001 + gl_FragCoord.y * 0.003;
  for (int i = 0; i < iterations; ++i) x = fract(x * 1.7 + 0.37);
  out_value = vec4(x);
}

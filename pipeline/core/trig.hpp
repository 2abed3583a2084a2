/// Sine, cosine and arc functions with the same bits on every x86-64 processor. The C library selects
/// variants with fused multiply-adds by processor, so no room may call std::sin or similar functions
/// (core/README.md). Error below one unit in the last place for |x| < 1e5 rad.
/// Source: polynomials of fdlibm (Sun Microsystems, 1993), k_sin.c, k_cos.c, s_atan.c.
#pragma once

namespace vrda::inline core {

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};

SinCos sin_cos(double angle_rad);
double sine(double angle_rad);
double cosine(double angle_rad);
/// Angle of the point (x, y) in (-pi, pi]; 0 for the origin.
double arc_tangent2(double y, double x);
/// Arguments outside [-1, 1] are clamped.
double arc_sine(double x);
double arc_cosine(double x);

}  // namespace vrda::inline core

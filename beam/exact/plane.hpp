// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Vectors of a plane, and their turn by a quarter: i(v) is e_z x v.
namespace flexura::beam::exact {

struct Vec2 {
  double x = 0.0, y = 0.0;

  Vec2& operator+=(const Vec2& b) {
    x += b.x;
    y += b.y;
    return *this;
  }
  Vec2& operator-=(const Vec2& b) {
    x -= b.x;
    y -= b.y;
    return *this;
  }
  friend Vec2 operator+(Vec2 a, const Vec2& b) { return a += b; }
  friend Vec2 operator-(Vec2 a, const Vec2& b) { return a -= b; }
  friend Vec2 operator*(double s, const Vec2& a) { return {s * a.x, s * a.y}; }
};
inline double dot(const Vec2& a, const Vec2& b) {
  return a.x * b.x + a.y * b.y;
}
inline double cross(const Vec2& a, const Vec2& b) {
  return a.x * b.y - a.y * b.x;
}
inline Vec2 i(const Vec2& a) {
  return {-a.y, a.x};
}
/// a turned by the angle whose cosine and sine are e: products of complex numbers.
inline Vec2 turned(const Vec2& e, const Vec2& a) {
  return {e.x * a.x - e.y * a.y, e.x * a.y + e.y * a.x};
}
inline Vec2 turned_back(const Vec2& e, const Vec2& a) {
  return {e.x * a.x + e.y * a.y, e.x * a.y - e.y * a.x};
}

}  // namespace flexura::beam::exact

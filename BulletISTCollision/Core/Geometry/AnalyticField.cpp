// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Geometry/AnalyticField.h"

#include "BulletISTCollision/Core/Geometry/Lens.h"

#include <limits>
#include <type_traits>

namespace ist
{
namespace
{
// Subdivision sizes as shares of a radius of curvature and of the half-width between two opposite sides. Source: FieldQueryTest.
constexpr double kSubdivisionOfRadius = 0.4, kSubdivisionOfHalf = 0.75;
constexpr double kTipShare = 0.04;  // share of a cone's height from the apex within which the subdivision size stays constant

bool isLength(double x) { return x > 0 && std::isfinite(x); }

/// Mean distance from a centre or an axis over a cloud; `offset` and `spread` exclude the components along the axis. Second order in the
/// cloud's size far out, finite and smooth at the centre.
struct MeanRadius
{
	double length;
	Vec3 direction;

	MeanRadius(const Vec3& offset, const SymmetricMatrix3& spread)
	{
		const double squared = squaredNorm(offset), trace = spread.trace();
		const double whole = squared + trace;
		const double across = whole > 0 ? trace - dot(offset, spread * offset) / whole : 0;
		length = std::sqrt(squared + std::max(across, 0.0));
		direction = length > 0 ? offset / length : Vec3{};
	}
	/// Derivative of the direction, for offsets that are the position multiplied by these factors.
	SymmetricMatrix3 bend(const Vec3& follows) const
	{
		if (!(length > 0)) return {};
		const SymmetricMatrix3 n = SymmetricMatrix3::square(componentProduct(direction, follows));
		return (SymmetricMatrix3{follows.x, follows.y, follows.z, 0, 0, 0} + n * -1.0) * (1 / length);
	}
};

SymmetricMatrix3 acrossAxis(const SymmetricMatrix3& s) { return {s.xx, s.yy, 0, s.xy, 0, 0}; }
}  // namespace

double AnalyticField::depth(const Vec3& p) const
{
	double least = side(0, p, {}).depth;
	for (int i = 1; i < sideCount(); ++i) least = std::min(least, side(i, p, {}).depth);
	return least;
}

Vec3 AnalyticField::normal(const Vec3& p) const
{
	FieldSide nearest = side(0, p, {});
	for (int i = 1; i < sideCount(); ++i)
		if (const FieldSide other = side(i, p, {}); other.depth < nearest.depth) nearest = other;
	return nearest.normal;
}

FieldSide HalfSpaceField::side(int, const Vec3& p, const SymmetricMatrix3&) const { return {m_offset - dot(m_normal, p), m_normal, {}}; }

Vec3 HalfSpaceField::subdivisionSize(const Vec3&) const
{
	constexpr double kAny = std::numeric_limits<double>::infinity();
	return {kAny, kAny, kAny};
}

double HalfSpaceField::volume() const { return std::numeric_limits<double>::infinity(); }
bool HalfSpaceField::isValid() const
{
	return isFinite(m_normal) && std::isfinite(m_offset) && std::fabs(squaredNorm(m_normal) - 1) <= 1e-4;
}

FieldSide BoxField::side(int index, const Vec3& p, const SymmetricMatrix3&) const
{
	const int axis = index / 2;
	const double sign = index % 2 ? -1 : 1;
	FieldSide s;
	s.depth = m_half[axis] - sign * p[axis];
	s.normal[axis] = sign;
	return s;
}

Vec3 BoxField::subdivisionSize(const Vec3&) const { return m_half * kSubdivisionOfHalf; }
bool BoxField::isValid() const { return isLength(m_half.x) && isLength(m_half.y) && isLength(m_half.z) && isLength(volume()); }

// Within the straight part, the nearest axis point moves with the position. For a cloud across its end it does so in part.
FieldSide CapsuleField::side(int, const Vec3& p, const SymmetricMatrix3& spread) const
{
	// Mean of max(0, t) over a unit ball centred at t, and its derivative.
	const auto beyond = [](double t) { return t <= -1 ? 0 : t >= 1 ? t : (1 + t) * (1 + t) * (1 + t) * (3 - t) / 16; };
	const auto share = [](double t) { return t <= -1 ? 0 : t >= 1 ? 1 : (1 + t) * (1 + t) * (2 - t) / 4; };
	const double reach = std::sqrt(5 * std::max(spread.zz, 0.0)), upper = p.z - m_half, lower = -p.z - m_half;
	double z = std::max(upper, 0.0) - std::max(lower, 0.0), follows = upper > 0 || lower > 0 ? 1 : 0;
	if (reach > 0 && m_half > 0)
	{
		z = reach * (beyond(upper / reach) - beyond(lower / reach));
		follows = std::min(1.0, share(upper / reach) + share(lower / reach));
	}
	const SymmetricMatrix3 s{spread.xx, spread.yy, spread.zz * follows * follows, spread.xy, spread.xz * follows, spread.yz * follows};
	const MeanRadius radius({p.x, p.y, z}, s);
	return {m_radius - radius.length, radius.direction, radius.bend({1, 1, follows})};
}

Vec3 CapsuleField::subdivisionSize(const Vec3& p) const
{
	const double across = kSubdivisionOfRadius * m_radius;
	return {across, across, across + kSubdivisionOfRadius * std::max(0.0, m_half - std::fabs(p.z))};
}

double CapsuleField::volume() const { return kPi * m_radius * m_radius * 2 * m_half + ballVolume(m_radius); }
bool CapsuleField::isValid() const { return isLength(m_radius) && m_half >= 0 && std::isfinite(m_half) && isLength(volume()); }

FieldSide CylinderField::side(int index, const Vec3& p, const SymmetricMatrix3& spread) const
{
	if (index == 1) return {m_half - p.z, {0, 0, 1}, {}};
	if (index == 2) return {m_half + p.z, {0, 0, -1}, {}};
	const MeanRadius radius({p.x, p.y, 0}, acrossAxis(spread));
	return {m_radius - radius.length, radius.direction, radius.bend({1, 1, 0})};
}

Vec3 CylinderField::subdivisionSize(const Vec3&) const
{
	return {kSubdivisionOfRadius * m_radius, kSubdivisionOfRadius * m_radius, kSubdivisionOfHalf * m_half};
}

double CylinderField::volume() const { return kPi * m_radius * m_radius * 2 * m_half; }
bool CylinderField::isValid() const { return isLength(m_radius) && isLength(m_half) && isLength(volume()); }

ConeField::ConeField(double radius, double height) : m_radius(radius), m_height(height)
{
	const double slant = std::hypot(radius, height);
	m_cos = height / slant;
	m_sin = radius / slant;
}

FieldSide ConeField::side(int index, const Vec3& p, const SymmetricMatrix3& spread) const
{
	if (index == 1) return {m_height / 2 + p.z, {0, 0, -1}, {}};
	const MeanRadius radius({p.x, p.y, 0}, acrossAxis(spread));
	const Vec3& u = radius.direction;
	return {m_cos * (radiusAt(p.z) - radius.length), {m_cos * u.x, m_cos * u.y, m_sin}, radius.bend({1, 1, 0}) * m_cos};
}

Vec3 ConeField::subdivisionSize(const Vec3& p) const
{
	const double share = std::max(kTipShare, std::min(1.0, radiusAt(p.z) / m_radius));
	const double across = kSubdivisionOfRadius * share * m_radius;
	return {across, across, kSubdivisionOfRadius * share * m_height};
}

double ConeField::volume() const { return kPi / 3 * m_radius * m_radius * m_height; }
bool ConeField::isValid() const { return isLength(m_radius) && isLength(m_height) && isLength(volume()); }

const AnalyticField* fieldIn(const AnyField& any)
{
	return std::visit(
		[](const auto& field) -> const AnalyticField* {
			if constexpr (std::is_same_v<std::decay_t<decltype(field)>, std::monostate>) return nullptr;
			else return field.isValid() ? &field : nullptr;
		},
		any);
}
}  // namespace ist

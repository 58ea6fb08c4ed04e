// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/Mesh.h"

#include <cstring>

namespace ist
{
namespace
{
/// The FNV-1a hash of 64 bits.
class Fnv1a
{
public:
	void addInteger(uint64_t value, int bytes)
	{
		for (int i = 0; i < bytes; ++i)
		{
			m_state ^= (value >> (8 * i)) & 0xff;
			m_state *= 0x100000001b3ull;
		}
	}
	void addDouble(double value)
	{
		uint64_t bits = 0;
		std::memcpy(&bits, &value, sizeof bits);
		addInteger(bits, 8);
	}
	uint64_t state() const { return m_state; }

private:
	uint64_t m_state = 0xcbf29ce484222325ull;
};
}  // namespace

Box bounds(const Mesh& mesh)
{
	if (mesh.triangles.empty()) return {};
	const Vec3& first = mesh.vertices[mesh.triangles[0][0]];
	Box box{first, first};
	for (const auto& triangle : mesh.triangles)
		for (const uint32_t corner : triangle)
		{
			box.lower = componentMin(box.lower, mesh.vertices[corner]);
			box.upper = componentMax(box.upper, mesh.vertices[corner]);
		}
	return box;
}

double surfaceArea(const Mesh& mesh)
{
	double area = 0;
	for (const auto& t : mesh.triangles)
	{
		const Vec3& a = mesh.vertices[t[0]];
		area += 0.5 * norm(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
	}
	return area;
}

MassProperties massProperties(const Mesh& mesh)
{
	const Box box = bounds(mesh);
	const Vec3 origin = box.lower + 0.5 * box.size();
	double volume = 0;
	Vec3 firstMoment;
	Mat3 secondMoment = zeroMat3();
	for (const auto& t : mesh.triangles)
	{
		const Vec3 a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin, c = mesh.vertices[t[2]] - origin;
		const Vec3 sum = a + b + c;
		const double det = dot(a, cross(b, c));
		volume += det / 6;
		firstMoment += (det / 24) * sum;
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) secondMoment.m[i][j] += det / 120 * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + sum[i] * sum[j]);
	}

	MassProperties result;
	result.volume = volume;
	result.centerOfMass = origin;
	if (volume == 0) return result;
	const Vec3 offset = firstMoment / volume;
	result.centerOfMass += offset;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) secondMoment.m[i][j] -= volume * offset[i] * offset[j];
	const double trace = secondMoment.m[0][0] + secondMoment.m[1][1] + secondMoment.m[2][2];
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) result.inertia.m[i][j] = (i == j ? trace : 0) - secondMoment.m[i][j];
	return result;
}

Mesh transformed(const Mesh& mesh, const Pose& X)
{
	Mesh result = mesh;
	for (Vec3& v : result.vertices) v = X * v;
	return result;
}

Mesh translated(const Mesh& mesh, const Vec3& offset)
{
	Mesh result = mesh;
	for (Vec3& v : result.vertices) v += offset;
	return result;
}

uint64_t meshHash(const Mesh& mesh)
{
	Fnv1a hash;
	for (const Vec3& v : mesh.vertices)
		for (int axis = 0; axis < 3; ++axis) hash.addDouble(v[axis]);
	for (const auto& triangle : mesh.triangles)
		for (const uint32_t corner : triangle) hash.addInteger(corner, 4);
	return hash.state();
}
}  // namespace ist

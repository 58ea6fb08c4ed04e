// SPDX-License-Identifier: Zlib
#include "demos/browser/render/BallBatch.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

using namespace ist;

namespace browser
{
namespace
{
// Number of visible spheres. The list begins with the largest, so the spheres that are too small even at the nearest point are at its
// end.
size_t seen(const DrawnSpheres& s, size_t count, const Vec3& eye, double angle)
{
	const auto& balls = s.model->spheres;
	const auto& first = balls.front();
	const double nearest = std::max(
		norm(s.X_WM * (s.scale * Vec3{first.x, first.y, first.z}) - eye) - 8 * s.scale * first.r, 1e-3 * norm(eye));
	const double least = angle * nearest / s.scale;
	const auto end = std::partition_point(
		balls.begin(), balls.begin() + std::ptrdiff_t(count), [&](const SpheresModel::Instance& b) { return double(b.r) >= least; });
	return size_t(end - balls.begin());
}

/// The next power of 5/4, so that a moving camera seldom needs another number.
size_t roundedUp(size_t count, size_t most)
{
	if (count == 0) return 0;
	return std::min(most, size_t(std::ceil(std::pow(1.25, std::ceil(std::log(double(count)) / std::log(1.25) - 1e-9)))));
}
}  // namespace

BallBatch::~BallBatch()
{
	if (m_array) glDeleteVertexArrays(1, &m_array);
	for (GLuint buffer : {m_buffer, m_poseBuffer})
		if (buffer) glDeleteBuffers(1, &buffer);
	if (m_poseTexture) glDeleteTextures(1, &m_poseTexture);
}

void BallBatch::start()
{
	glGenVertexArrays(1, &m_array);
	glBindVertexArray(m_array);
	glGenBuffers(1, &m_buffer);
	glBindBuffer(GL_ARRAY_BUFFER, m_buffer);
	for (const GLuint location : {0u, 1u})
	{
		glEnableVertexAttribArray(location);
		glVertexAttribPointer(location, location == 0 ? 4 : 2, GL_FLOAT, GL_FALSE, sizeof(Ball),
			reinterpret_cast<const void*>(location * offsetof(Ball, shade)));
		glVertexAttribDivisor(location, 1);
	}
	glGenBuffers(1, &m_poseBuffer);
	glGenTextures(1, &m_poseTexture);
}

void BallBatch::choose(const std::vector<DrawnSpheres>& bodies, const Vec3& eye, double angle)
{
	m_count = m_leftOut = 0;
	m_poses.clear();
	size_t used = 0;
	for (const DrawnSpheres& s : bodies)
	{
		const size_t wanted = std::min(s.count, s.model->spheres.size()), visible = wanted > 0 ? seen(s, wanted, eye, angle) : 0;
		if (visible == 0)
		{
			m_leftOut += wanted;
			continue;
		}
		if (used == m_parts.size()) m_parts.emplace_back();
		Part& part = m_parts[used++];
		// The last body's spheres are all in the buffer, and only the wanted number is drawn. So a growing packing needs no new buffer.
		const bool last = &s == &bodies.back();
		const size_t stored = last ? s.model->spheres.size() : roundedUp(visible, wanted), drawn = last ? visible : stored;
		if (part.model != s.model || part.count != stored)
		{
			part = {s.model, stored};
			m_stale = true;
		}
		m_count += drawn;
		m_leftOut += wanted - drawn;
		for (int row = 0; row < 3; ++row)
			for (int column = 0; column < 4; ++column)
				m_poses.push_back(float(column < 3 ? s.scale * s.X_WM.rotation.m[row][column] : s.X_WM.translation[row]));
	}
	// Old parts are removed too, so that unused models can be freed.
	if (used < m_parts.size()) m_stale = true, m_parts.resize(used);
	if (m_stale) gather();
}

void BallBatch::gather()
{
	m_balls.clear();
	for (size_t i = 0; i < m_parts.size(); ++i)
		for (size_t k = 0; k < m_parts[i].count; ++k)
		{
			const SpheresModel::Instance& b = m_parts[i].model->spheres[k];
			m_balls.push_back({b.x, b.y, b.z, b.r, b.shade, float(i)});
		}
}

void BallBatch::upload(GLenum unit)
{
	if (m_count == 0) return;
	if (m_stale)
	{
		glBindBuffer(GL_ARRAY_BUFFER, m_buffer);
		glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(m_balls.size() * sizeof(Ball)), m_balls.data(), GL_STATIC_DRAW);
		m_stale = false;
	}
	glBindBuffer(GL_TEXTURE_BUFFER, m_poseBuffer);
	glBufferData(GL_TEXTURE_BUFFER, GLsizeiptr(m_poses.size() * sizeof(float)), m_poses.data(), GL_STREAM_DRAW);
	glActiveTexture(unit);
	glBindTexture(GL_TEXTURE_BUFFER, m_poseTexture);
	glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, m_poseBuffer);
	glActiveTexture(GL_TEXTURE0);
}

void BallBatch::draw() const
{
	if (m_count == 0) return;
	glBindVertexArray(m_array);
	glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, GLsizei(m_count));
}
}  // namespace browser

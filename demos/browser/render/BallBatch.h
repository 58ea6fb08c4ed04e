// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/drawing/DrawList.h"
#include "demos/browser/render/Gl.h"

#include <vector>

namespace browser
{
/// The packed spheres of all bodies of a picture, drawn by one call. The spheres stay in the memory of the graphics card while the same
/// models are drawn. The poses of the bodies are uploaded for each picture.
class BallBatch
{
public:
	~BallBatch();
	void start();

	/// Chooses the spheres that are visible from `eye` with an angular radius of at least `angle` [rad]. Cost: O(bodies). It is
	/// O(spheres) when other models than before are drawn, or many more or fewer spheres.
	void choose(const std::vector<DrawnSpheres>& bodies, const ist::Vec3& eye, double angle);
	/// Uploads what is new to the graphics card, and the poses to texture unit `unit`.
	void upload(GLenum unit);
	/// Draws instances of a square of four corners. Attributes 0 and 1 are position and radius, shade and body.
	void draw() const;

	size_t count() const { return m_count; }
	/// Number of requested spheres that are too small to be seen.
	size_t leftOut() const { return m_leftOut; }

private:
	struct Ball
	{
		float x, y, z, r, shade, body;
	};
	struct Part
	{
		std::shared_ptr<const SpheresModel> model;
		size_t count = 0;  // number of its spheres in the buffer
	};
	void gather();

	std::vector<Part> m_parts;
	std::vector<Ball> m_balls;
	std::vector<float> m_poses;  // three rows of four numbers for each body
	size_t m_count = 0, m_leftOut = 0;
	bool m_stale = false;
	GLuint m_array = 0, m_buffer = 0, m_poseBuffer = 0, m_poseTexture = 0;
};
}  // namespace browser

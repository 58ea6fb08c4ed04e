// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/drawing/DrawList.h"
#include "demos/browser/render/Gl.h"

#include <vector>

namespace browser
{
/// The packed spheres of all bodies of a picture, drawn by one call. The spheres stay in the memory of the graphics card while the same
/// models are drawn; the poses of the bodies go there for each picture.
class BallBatch
{
public:
	~BallBatch();
	void start();

	/// Chooses what is seen from `eye` with a radius of at least `angle` [rad]. O(bodies); where other models than before are drawn, or
	/// much more or less of them, O(spheres).
	void choose(const std::vector<DrawnSpheres>& bodies, const ist::Vec3& eye, double angle);
	/// To the graphics card, what is new; the poses to texture unit `unit`.
	void upload(GLenum unit);
	/// Instances of a square of four corners; attributes 0 and 1 are place and radius, shade and body.
	void draw() const;

	size_t count() const { return m_count; }
	/// Of the spheres that were to be drawn those that are too small to be seen.
	size_t leftOut() const { return m_leftOut; }

private:
	struct Ball
	{
		float x, y, z, r, shade, body;
	};
	struct Part
	{
		std::shared_ptr<const SpheresModel> model;
		size_t count = 0;  // of it in the buffer
	};
	void gather();

	std::vector<Part> m_parts;
	std::vector<Ball> m_balls;
	std::vector<float> m_poses;  // of each body three rows of four
	size_t m_count = 0, m_leftOut = 0;
	bool m_stale = false;
	GLuint m_array = 0, m_buffer = 0, m_poseBuffer = 0, m_poseTexture = 0;
};
}  // namespace browser

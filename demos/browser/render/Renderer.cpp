// SPDX-License-Identifier: Zlib
#include "demos/browser/render/Renderer.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "demos/browser/render/BallBatch.h"
#include "demos/browser/render/ModelStore.h"
#include "demos/browser/render/Shaders.h"
#include "demos/browser/render/Stopwatch.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

using namespace ist;

namespace browser
{
namespace
{
/// Camera of the light; it covers everything that casts a shadow.
struct Lamp
{
	Vec3 toLight = normalized({0.45, 0.85, 0.30});
	Matrix4 view, projection;
};

struct Around
{
	Vec3 center;
	double radius = 0;
};

Around boundsOf(const DrawList& list)
{
	Vec3 lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};
	const auto take = [&](const Pose& X, const Box& box, double scale) {
		const Vec3 c = X * (0.5 * scale * (box.lower + box.upper));
		const double r = 0.5 * scale * norm(box.size());
		lower = componentMin(lower, c - Vec3{r, r, r});
		upper = componentMax(upper, c + Vec3{r, r, r});
	};
	for (const DrawnSurface& s : list.surfaces) take(s.X_WM, s.model->box, s.scale);
	for (const DrawnSpheres& s : list.spheres)
		if (!s.model->spheres.empty())
		{
			const auto& b = s.model->spheres.front();
			take(s.X_WM, {{b.x - 4 * b.r, b.y - 4 * b.r, b.z - 4 * b.r}, {b.x + 4 * b.r, b.y + 4 * b.r, b.z + 4 * b.r}}, s.scale);
		}
	if (lower.x > upper.x) return {{}, 1};
	return {0.5 * (lower + upper), 0.5 * norm(upper - lower)};
}

int drawnPixels(int seen, const RenderQuality& quality) { return std::max(1, int(std::lround(seen * quality.pixels))); }

Lamp lampFor(const Around& around)
{
	Lamp lamp;
	const double r = std::max(around.radius, 1e-9) * 1.02;
	Vec3 u, v;
	completeFrame(lamp.toLight, u, v);
	const Mat3 axes{{{u.x, v.x, lamp.toLight.x}, {u.y, v.y, lamp.toLight.y}, {u.z, v.z, lamp.toLight.z}}};
	lamp.view = matrixOf(inverse(Pose{axes, around.center + 2 * r * lamp.toLight}));
	lamp.projection = orthographic(r, 0.5 * r, 3.5 * r);
	return lamp;
}
}  // namespace

struct Renderer::Implementation
{
	GlProgram solid, solidShadow, ball, ballShadow, line, ground, backdrop, occlusion, compose;
	GlTarget shadow, picture, share;
	ModelStore models;
	BallBatch balls;
	GLuint ramp = 0, empty = 0;
	RenderCost cost;
	std::string device;
	bool software = false;

	std::optional<Error> start();
	void makeRamp();
	void light(const GlProgram& program, const Lamp& lamp, const Camera& camera, const RenderQuality& quality) const;
	void drawSurfaces(const DrawList& list, bool glass);
	void drawBalls(const GlProgram& program, const Matrix4& view, const Matrix4& projection, bool orthographic, double pixels);
	Lamp prepare(const DrawList& list, const Vec3& eye, double leastAngle);
	void drawShadows(const DrawList& list, const Lamp& lamp, const RenderQuality& quality);
	void drawGround(const DrawList& list, const Lamp& lamp, const Camera& camera, const Matrix4& both, const RenderQuality& quality);
	void drawGlyphs(const DrawList& list, const Lamp& lamp, const Camera& camera, const Matrix4& both, const RenderQuality& quality);
	void finish(const Camera& camera, unsigned target, const PixelArea& area, const RenderQuality& quality);
	~Implementation()
	{
		if (ramp) glDeleteTextures(1, &ramp);
		if (empty) glDeleteVertexArrays(1, &empty);
	}
};

void Renderer::Implementation::makeRamp()
{
	std::vector<unsigned char> texels;
	for (int i = 0; i < 256; ++i)
	{
		const Colour c = shadeColour(i / 255.0);
		for (const float part : {c.r, c.g, c.b}) texels.push_back(static_cast<unsigned char>(255 * part + 0.5f));
	}
	glGenTextures(1, &ramp);
	glBindTexture(GL_TEXTURE_1D, ramp);
	glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
	glTexImage1D(GL_TEXTURE_1D, 0, GL_RGB8, 256, 0, GL_RGB, GL_UNSIGNED_BYTE, texels.data());
	glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
	glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
}

std::optional<Error> Renderer::Implementation::start()
{
	using namespace shaders;
	const auto text = [](GLenum name) {
		return std::string(reinterpret_cast<const char*>(glGetString(name)) ? reinterpret_cast<const char*>(glGetString(name)) : "");
	};
	device = text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
	software = device.find("llvmpipe") != std::string::npos || device.find("softpipe") != std::string::npos ||
		device.find("SWR") != std::string::npos;
	struct Row
	{
		GlProgram* program;
		const char* name;
		std::string vertex, fragment;
	};
	const Row rows[] = {{&solid, "surfaces", solidVertex(), solidFragment()},
		{&solidShadow, "shadows", solidVertex(), solidShadowFragment()}, {&ball, "balls", ballVertex(), ballFragment()},
		{&ballShadow, "shadows of balls", ballVertex(), ballShadowFragment()}, {&line, "lines", lineVertex(), lineFragment()},
		{&ground, "the ground", groundVertex(), groundFragment()}, {&backdrop, "the background", screenVertex(), backgroundFragment()},
		{&occlusion, "ambient occlusion", screenVertex(), occlusionFragment()},
		{&compose, "the picture", screenVertex(), composeFragment()}};
	for (const Row& row : rows)
		if (auto error = row.program->build(row.name, row.vertex, row.fragment)) return error;
	glGenVertexArrays(1, &empty);
	makeRamp();
	models.start();
	balls.start();
	return std::nullopt;
}

void Renderer::Implementation::light(const GlProgram& program, const Lamp& lamp, const Camera& camera, const RenderQuality& quality) const
{
	program.set("uToLight", lamp.toLight);
	program.set("uEye", camera.eye());
	program.set("uShadow", lamp.projection * lamp.view);
	program.set("uShadowMap", 1);
	program.set("uShadowTexel", 1.0f / float(quality.shadowSize));
	program.set("uShadowTaps", quality.shadowTaps);
	glActiveTexture(GL_TEXTURE1);
	glBindTexture(GL_TEXTURE_2D, shadow.depth());
	glActiveTexture(GL_TEXTURE0);
}

Lamp Renderer::Implementation::prepare(const DrawList& list, const Vec3& eye, double leastAngle)
{
	Lamp lamp;
	{
		const Stopwatch watch(cost.ownMicroseconds);
		lamp = lampFor(boundsOf(list));
		balls.choose(list.spheres, eye, leastAngle);
	}
	balls.upload(GL_TEXTURE3);
	cost.ballsDrawn += balls.count();
	cost.ballsLeftOut += balls.leftOut();
	return lamp;
}

void Renderer::Implementation::drawSurfaces(const DrawList& list, bool glass)
{
	for (const DrawnSurface& s : list.surfaces)
		if (s.glass == glass) models.drawSurface(s);
}

void Renderer::Implementation::drawBalls(
	const GlProgram& program, const Matrix4& view, const Matrix4& projection, bool orthographic, double pixels)
{
	if (balls.count() == 0) return;
	program.use();
	program.set("uProjection", projection);
	program.set("uView", view);
	program.set("uOrthographic", orthographic ? 1 : 0);
	program.set("uPixels", float(pixels));
	program.set("uRamp", 2);
	program.set("uBodies", 3);
	glActiveTexture(GL_TEXTURE2);
	glBindTexture(GL_TEXTURE_1D, ramp);
	glActiveTexture(GL_TEXTURE0);
	balls.draw();
	++cost.drawCalls;
}

void Renderer::Implementation::drawShadows(const DrawList& list, const Lamp& lamp, const RenderQuality& quality)
{
	shadow.resize(quality.shadowSize, quality.shadowSize, 0, true, true);
	shadow.bind();
	glClear(GL_DEPTH_BUFFER_BIT);
	solidShadow.use();
	solidShadow.set("uViewProjection", lamp.projection * lamp.view);
	drawSurfaces(list, false);
	drawBalls(ballShadow, lamp.view, lamp.projection, true, 1e6);
}

void Renderer::Implementation::drawGround(
	const DrawList& list, const Lamp& lamp, const Camera& camera, const Matrix4& both, const RenderQuality& quality)
{
	if (!list.ground) return;
	ground.use();
	light(ground, lamp, camera, quality);
	Vec3 u, v;
	const Vec3& n = list.groundNormal;
	u = normalized(cross(n, {0, 0, 1}));
	if (!(squaredNorm(u) > 0)) u = {1, 0, 0};
	v = cross(u, n);
	const Vec3 origin = list.groundHeight * n, target = camera.viewpoint().target;
	ground.set("uViewProjection", both);
	ground.set("uU", u);
	ground.set("uV", v);
	ground.set("uOrigin", origin);
	ground.set("uCenter", target - dot(target - origin, n) * n);
	ground.set("uExtent", float(4.5 * camera.viewpoint().distance));
	ground.set("uCell", float(list.gridCell));
	ground.set("uSize", float(picture.width()), float(picture.height()));
	ground.set("uWater", list.water ? 1 : 0);
	glBindVertexArray(empty);
	glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
	++cost.drawCalls;
}

void Renderer::Implementation::drawGlyphs(
	const DrawList& list, const Lamp& lamp, const Camera& camera, const Matrix4& both, const RenderQuality& quality)
{
	solid.use();
	light(solid, lamp, camera, quality);
	solid.set("uGlass", 0);
	models.drawDiscs(list.discs);
	models.drawArrows(list.arrows, 1);
	// Arrows are drawn again where bodies hide them, because a force must be visible inside its body.
	glDepthFunc(GL_GREATER);
	glDepthMask(GL_FALSE);
	models.drawArrows(list.arrows, 0.4f);
	glDepthMask(GL_TRUE);
	glDepthFunc(GL_LESS);
	line.use();
	line.set("uViewProjection", both);
	line.set("uSize", float(picture.width()), float(picture.height()));
	line.set("uWidth", float(1.1 * picture.height() / 540.0 + 0.4 * quality.pixels));
	models.drawLines(list.lines);
}

void Renderer::Implementation::finish(const Camera& camera, unsigned target, const PixelArea& area, const RenderQuality& quality)
{
	glDisable(GL_DEPTH_TEST);
	glBindVertexArray(empty);
	const double aspect = area.aspect();
	if (quality.occlusion)
	{
		share.resize(area.width, area.height, GL_R8, false);
		share.bind();
		occlusion.use();
		glBindTexture(GL_TEXTURE_2D, picture.depth());
		occlusion.set("uDepth", 0);
		occlusion.set("uFromClip", inversePerspective(camera.projection(aspect)));
		occlusion.set("uReach", float(0.07 * camera.viewpoint().distance));
		occlusion.set("uAspect", float(aspect));
		occlusion.set("uHeightShare", float(1 / camera.heightAt(1, aspect)));
		glDrawArrays(GL_TRIANGLES, 0, 3);
		++cost.drawCalls;
	}
	glBindFramebuffer(GL_FRAMEBUFFER, target);
	glViewport(area.left, 0, area.width, area.height);
	compose.use();
	compose.set("uColour", 0);
	compose.set("uShare", 1);
	compose.set("uDepth", 2);
	compose.set("uOcclusion", quality.occlusion ? 1 : 0);
	const GLuint textures[] = {picture.colour(), quality.occlusion ? share.colour() : picture.colour(), picture.depth()};
	for (GLuint i = 0; i < 3; ++i)
	{
		glActiveTexture(GL_TEXTURE0 + i);
		glBindTexture(GL_TEXTURE_2D, textures[i]);
	}
	glActiveTexture(GL_TEXTURE0);
	glDrawArrays(GL_TRIANGLES, 0, 3);
	++cost.drawCalls;
}

void Renderer::draw(const DrawList& list, const Camera& camera, unsigned target, const PixelArea& area, const RenderQuality& wanted)
{
	if (area.empty()) return;
	const auto start = std::chrono::steady_clock::now();
	Implementation& im = *m_impl;
	RenderQuality quality = wanted;
	if (!list.shadows) quality.shadowTaps = 0;
	const double aspect = area.aspect(), pixels = area.height * quality.pixels / camera.heightAt(1, aspect);
	const Lamp lamp = im.prepare(list, camera.eye(), quality.leastRadius / pixels);
	const Matrix4 view = camera.view(), projection = camera.projection(aspect), both = projection * view;
	glEnable(GL_DEPTH_TEST);
	glDepthFunc(GL_LESS);
	glDisable(GL_BLEND);
	glDisable(GL_SCISSOR_TEST);
	if (quality.shadowTaps > 0) im.drawShadows(list, lamp, quality);
	im.picture.resize(drawnPixels(area.width, quality), drawnPixels(area.height, quality), GL_RGBA8, true);
	im.picture.bind();
	glClear(GL_DEPTH_BUFFER_BIT);
	glDepthMask(GL_FALSE);
	im.backdrop.use();
	glBindVertexArray(im.empty);
	glDrawArrays(GL_TRIANGLES, 0, 3);
	++im.cost.drawCalls;
	glDepthMask(GL_TRUE);
	if (!list.water) im.drawGround(list, lamp, camera, both, quality);

	im.solid.use();
	im.light(im.solid, lamp, camera, quality);
	im.solid.set("uViewProjection", both);
	im.solid.set("uGlass", 0);
	if (list.wireframe) glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
	im.drawSurfaces(list, false);
	glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
	im.ball.use();
	im.light(im.ball, lamp, camera, quality);
	im.ball.set("uFromView", matrixOf(Pose{camera.axes(), camera.eye()}));
	im.drawBalls(im.ball, view, projection, false, pixels);

	glEnable(GL_BLEND);
	glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
	im.drawGlyphs(list, lamp, camera, both, quality);
	im.solid.use();
	im.solid.set("uGlass", 1);
	glDepthMask(GL_FALSE);
	glEnable(GL_CULL_FACE);
	im.drawSurfaces(list, true);
	glDisable(GL_CULL_FACE);
	if (list.water) im.drawGround(list, lamp, camera, both, quality);
	glDepthMask(GL_TRUE);
	glDisable(GL_BLEND);
	im.finish(camera, target, area, quality);
	im.models.forgetUnused();
	im.cost.ownMicroseconds += im.models.takeFillMicroseconds();
	im.cost.drawCalls += im.models.takeDrawCalls();
	im.cost.microseconds += 1e6 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Renderer::Renderer(std::unique_ptr<Implementation> implementation) : m_impl(std::move(implementation)) {}
Renderer::~Renderer() = default;
void Renderer::beginPicture() { m_impl->cost = {}; }
void Renderer::addOwnTime(double microseconds) { m_impl->cost.ownMicroseconds += microseconds; }
const RenderCost& Renderer::cost() const { return m_impl->cost; }
bool Renderer::software() const { return m_impl->software; }
const std::string& Renderer::device() const { return m_impl->device; }

Result<std::unique_ptr<Renderer>> Renderer::make()
{
	auto made = std::make_unique<Implementation>();
	if (auto error = made->start()) return *error;
	return std::unique_ptr<Renderer>(new Renderer(std::move(made)));
}
}  // namespace browser

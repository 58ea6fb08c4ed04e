// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/DeviceHand.h"
#include "demos/browser/catalog/BesideStock.h"
#include "demos/browser/view/AffordableQuality.h"
#include "demos/browser/view/Gui.h"
#include "demos/browser/view/SceneView.h"

#include <deque>
#include <memory>
#include <string>

namespace browser
{
/// The keys that the browser knows, as Bullet's browser has them.
enum class Key
{
	Boxes,         ///< a
	Contacts,      ///< c
	NoSleep,       ///< d
	Frames,        ///< j
	Constraints,   ///< k, l
	Wireframe,     ///< w
	Surfaces,      ///< v
	Panels,        ///< g: grid and panels
	Pause,         ///< i, space
	Step,          ///< o
	Profile,       ///< p
	Shadows,       ///< s
	Restart,       ///< r
	Spheres,       ///< b: by size
	SphereLevels,  ///< e: by level
	Leaves,        ///< n
	Lenses,        ///< m
	Levels,        ///< t: what answers
	Halves,        ///< h: beside stock Bullet
	Picture        ///< F1
};

/// The whole browser, panels and all, on a demo that ran for so many seconds of its own time. No window, no display.
ist::Result<Picture> takeBrowserPicture(const std::string& demo, double seconds, const DemoOptions& options, int width, int height);

/// The browser without its window: which demo runs, what is shown, the panels. Who owns the window, or none, feeds it with input and time.
class Browser
{
public:
	Browser(Renderer& renderer, Gui& gui, const DemoOptions& options);

	/// Takes the place of the demo before; an error leaves that one, and is shown.
	void open(const std::string& name);
	/// A mesh for the demos that take any, and the packing of it: what a file that is dropped does.
	void openMesh(const std::string& path);
	void key(Key key);
	/// From here on it moves what the demo has for a hand.
	void use(std::unique_ptr<DeviceHand> device) { m_device = std::move(device); }
	/// Mouse on the scene: shares of the scene's width and height, from its upper left corner. `turns`: the modifier is held.
	void press(double x, double y, bool onCamera);
	void drag(double x, double y, bool turns, bool pans, bool zooms);
	void releaseMouse();
	void wheel(double notches) { m_camera.zoom(notches); }

	/// Steps the demo by so many seconds of the wall clock, at its own speed, and no longer than the picture may take.
	void advance(double seconds);
	/// Scene and panels, between the Gui's `begin` and `end`.
	void draw(unsigned target, int width, int height);

	/// Left edge and width of the scene in the picture [pixels].
	double sceneLeft() const { return m_sceneLeft; }
	double sceneWidth() const { return m_sceneWidth; }
	/// True once when F1 was pressed.
	bool wantsPicture();
	/// As well as it can be drawn, however long that takes.
	void beautiful() { m_thrifty = false, m_quality = {}; }
	bool paused() const { return m_paused; }
	const BrowsableDemo* demo() const { return m_demo.get(); }
	/// What went wrong, for as long as it matters: what could not be opened, a device that does not answer. Empty: nothing.
	std::string message() const;
	DrawChoice& choice() { return m_choice; }
	Camera& camera() { return m_camera; }

private:
	void drawTree(float width, float height);
	void drawControls();
	void drawParameters();
	void drawFigures();
	void drawCurves();
	void drawProfile();
	void drawPairs();
	void drawChoices();
	void stepOnce();
	RenderQuality quality() const;
	bool start(const DemoEntry& entry);
	void toggleHalves();
	/// The view under a share of the width of the scene, which becomes that of the view; null before the first picture.
	const SceneView* viewAt(double& x) const;
	double viewAspect() const { return m_views.empty() ? 1 : m_views.front().area.aspect(); }

	Renderer& m_renderer;
	Gui& m_gui;
	DemoOptions m_options;
	std::unique_ptr<BrowsableDemo> m_demo;
	std::unique_ptr<DeviceHand> m_device;
	const DemoEntry* m_entry = nullptr;
	Camera m_camera;
	DrawChoice m_choice;
	ScenePainter m_painter;
	std::vector<SceneView> m_views;
	RenderQuality m_quality;
	AffordableQuality m_affordable;
	bool m_thrifty = false;  // as good as can be afforded, but for the occlusion, which the user chooses
	double m_stepping = 0;   // of the time between the last two pictures [s]
	std::string m_message;
	char m_search[64] = {};
	double m_owed = 0, m_speed = 1, m_sceneLeft = 0, m_sceneWidth = 0, m_sceneHeight = 0;
	double m_mouseX = 0, m_mouseY = 0, m_grip = 0;
	ContactCacheChoice m_contactCache;
	bool m_halves = false, m_hasStockSide = false;
	bool m_paused = false, m_panels = true, m_profile = false, m_noSleep = true, m_held = false, m_touched = false, m_wantsPicture = false;
	std::deque<float> m_stepTimes, m_frameTimes;  // [us, ms]
	std::vector<float> m_rates;                   // steps in a second of the wall clock, for each picture
	double m_rate = 0;
};
}  // namespace browser

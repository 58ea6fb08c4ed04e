// SPDX-License-Identifier: Zlib
#include "demos/browser/view/Window.h"

#include "demos/browser/render/Gl.h"
#include "demos/browser/view/Browser.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include <algorithm>
#include <filesystem>
#include <map>

namespace browser
{
namespace
{
std::string lastGlfwError()
{
	const char* text = nullptr;
	glfwGetError(&text);
	return text ? text : "no reason given";
}

/// The GLFW library, the window and its context, released in the right order.
struct GlfwWindow
{
	bool begun = false;
	GLFWwindow* window = nullptr;
	~GlfwWindow()
	{
		if (window) glfwDestroyWindow(window);
		if (begun) glfwTerminate();
	}
};

const std::map<int, Key>& keys()
{
	static const std::map<int, Key> table = {{GLFW_KEY_A, Key::Boxes}, {GLFW_KEY_C, Key::Contacts}, {GLFW_KEY_D, Key::NoSleep},
		{GLFW_KEY_J, Key::Frames}, {GLFW_KEY_K, Key::Constraints}, {GLFW_KEY_L, Key::Constraints}, {GLFW_KEY_W, Key::Wireframe},
		{GLFW_KEY_V, Key::Surfaces}, {GLFW_KEY_G, Key::Panels}, {GLFW_KEY_I, Key::Pause}, {GLFW_KEY_SPACE, Key::Pause},
		{GLFW_KEY_O, Key::Step}, {GLFW_KEY_P, Key::Profile}, {GLFW_KEY_S, Key::Shadows}, {GLFW_KEY_R, Key::Restart},
		{GLFW_KEY_B, Key::Spheres}, {GLFW_KEY_E, Key::SphereLevels}, {GLFW_KEY_N, Key::Leaves}, {GLFW_KEY_M, Key::Lenses},
		{GLFW_KEY_T, Key::Levels}, {GLFW_KEY_U, Key::Pairs}, {GLFW_KEY_H, Key::Halves}, {GLFW_KEY_F1, Key::Picture},
		{GLFW_KEY_F2, Key::SaveScene}};
	return table;
}

Browser& browserOf(GLFWwindow* window) { return *static_cast<Browser*>(glfwGetWindowUserPointer(window)); }

bool isDown(GLFWwindow* window, int left, int right)
{
	return glfwGetKey(window, left) == GLFW_PRESS || glfwGetKey(window, right) == GLFW_PRESS;
}

/// Position of the cursor, as shares of the scene's size.
void cursorInScene(GLFWwindow* window, double& x, double& y)
{
	int width = 1, height = 1, pixels = 1, ignored = 1;
	glfwGetWindowSize(window, &width, &height);
	glfwGetFramebufferSize(window, &pixels, &ignored);
	glfwGetCursorPos(window, &x, &y);
	const Browser& browser = browserOf(window);
	x = (x * pixels / std::max(width, 1) - browser.sceneLeft()) / std::max(browser.sceneWidth(), 1.0);
	y /= std::max(height, 1);
}

void onKey(GLFWwindow* window, int key, int, int action, int)
{
	if (action != GLFW_PRESS || ImGui::GetIO().WantTextInput) return;
	if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(window, GLFW_TRUE);
	const auto known = keys().find(key);
	if (known != keys().end()) browserOf(window).key(known->second);
}

void onButton(GLFWwindow* window, int button, int action, int)
{
	Browser& browser = browserOf(window);
	if (action == GLFW_RELEASE)
	{
		if (button == GLFW_MOUSE_BUTTON_LEFT) browser.releaseMouse();
		return;
	}
	if (ImGui::GetIO().WantCaptureMouse) return;
	double x = 0, y = 0;
	cursorInScene(window, x, y);
	const bool camera = button != GLFW_MOUSE_BUTTON_LEFT || isDown(window, GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT) ||
		isDown(window, GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL);
	browser.press(x, y, camera);
}

void onMove(GLFWwindow* window, double, double)
{
	const auto down = [&](int button) { return glfwGetMouseButton(window, button) == GLFW_PRESS; };
	const bool left = down(GLFW_MOUSE_BUTTON_LEFT), middle = down(GLFW_MOUSE_BUTTON_MIDDLE), right = down(GLFW_MOUSE_BUTTON_RIGHT);
	if (!(left || middle || right) || ImGui::GetIO().WantCaptureMouse) return;
	double x = 0, y = 0;
	cursorInScene(window, x, y);
	browserOf(window).drag(x, y, isDown(window, GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT), middle, right);
}

void onWheel(GLFWwindow* window, double, double notches)
{
	if (!ImGui::GetIO().WantCaptureMouse) browserOf(window).wheel(notches);
}

void onDrop(GLFWwindow* window, int count, const char** paths)
{
	if (count > 0) browserOf(window).openMesh(paths[0]);
}

std::optional<ist::Error> openGlfw(GlfwWindow& glfw, const WindowOptions& options)
{
	if (!glfwInit())
		return ist::Error{"no window can be opened (" + lastGlfwError() +
			"); without a display, give --demo NAME and --headless or --screenshot FILE.png"};
	glfw.begun = true;
	glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
	glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
	glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
	glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
	glfw.window = glfwCreateWindow(options.width, options.height, "BulletHaptics", nullptr, nullptr);
	if (!glfw.window)
		return ist::Error{
			"no window with OpenGL 3.3 (" + lastGlfwError() + "); --demo NAME with --headless or --screenshot FILE.png needs none"};
	glfwMakeContextCurrent(glfw.window);
	glfwSwapInterval(1);
	return std::nullopt;
}

void savePictureOf(int width, int height, const std::string& path)
{
	Picture picture{width, height, std::vector<uint8_t>(size_t(3) * size_t(width) * size_t(height))};
	glPixelStorei(GL_PACK_ALIGNMENT, 1);
	glBindFramebuffer(GL_FRAMEBUFFER, 0);
	glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, picture.pixels.data());
	const size_t row = size_t(3) * size_t(width);
	for (int y = 0; y < height / 2; ++y)
		std::swap_ranges(picture.pixels.begin() + std::ptrdiff_t(row) * y, picture.pixels.begin() + std::ptrdiff_t(row) * (y + 1),
			picture.pixels.begin() + std::ptrdiff_t(row) * (height - 1 - y));
	if (auto error = savePicture(picture, path)) std::fprintf(stderr, "haptic_demos: %s\n", error->message.c_str());
	else std::fprintf(stderr, "picture: %s\n", path.c_str());
}

std::string freeName(const std::string& folder)
{
	std::error_code ignored;
	for (int i = 1; i < 10000; ++i)
	{
		const std::string path = (std::filesystem::path(folder) / ("haptic-demos-" + std::to_string(i) + ".png")).string();
		if (!std::filesystem::exists(path, ignored)) return path;
	}
	return (std::filesystem::path(folder) / "haptic-demos.png").string();
}

void resize(GLFWwindow* window, const std::pair<int, int>& size)
{
	if (size.first == 0 || size.second == 0) return glfwIconifyWindow(window);
	glfwRestoreWindow(window);
	glfwSetWindowSize(window, size.first, size.second);
}

void loop(GLFWwindow* window, Browser& browser, Gui& gui, const WindowOptions& options)
{
	double last = glfwGetTime();
	for (long long picture = 0; !glfwWindowShouldClose(window) && (options.pictures < 0 || picture < options.pictures); ++picture)
	{
		if (picture < static_cast<long long>(options.sizes.size())) resize(window, options.sizes[size_t(picture)]);
		glfwPollEvents();
		int width = 0, height = 0;
		glfwGetFramebufferSize(window, &width, &height);
		const double time = glfwGetTime();
		browser.advance(time - last);
		last = time;
		// X11 keeps the size of a minimised window; other systems set it to zero.
		const bool minimised = width <= 0 || height <= 0 || glfwGetWindowAttrib(window, GLFW_ICONIFIED);
		if (options.beforePicture) options.beforePicture(minimised);
		if (minimised)
		{
			glfwWaitEventsTimeout(0.05);
			continue;
		}
		ImGui_ImplGlfw_NewFrame();
		gui.begin();
		browser.draw(0, width, height);
		gui.end(0, width, height);
		if (browser.wantsPicture()) savePictureOf(width, height, freeName(options.pictureFolder));
		if (!options.screenshot.empty() && picture + 1 == options.pictures) savePictureOf(width, height, options.screenshot);
		glfwSwapBuffers(window);
		if (options.afterPicture) options.afterPicture();
	}
}
}  // namespace

std::optional<ist::Error> openWindow(const WindowOptions& options)
{
	GlfwWindow glfw;
	if (auto error = openGlfw(glfw, options)) return error;
	auto renderer = Renderer::make();
	if (!renderer) return renderer.error();
	float density = 1, ignored = 1;
	glfwGetWindowContentScale(glfw.window, &density, &ignored);
	Gui gui(static_cast<double>(density));
	Browser browser(*renderer.value(), gui, options.demo);
	glfwSetWindowUserPointer(glfw.window, &browser);
	// ImGui calls these callbacks before its own.
	glfwSetKeyCallback(glfw.window, onKey);
	glfwSetMouseButtonCallback(glfw.window, onButton);
	glfwSetCursorPosCallback(glfw.window, onMove);
	glfwSetScrollCallback(glfw.window, onWheel);
	glfwSetDropCallback(glfw.window, onDrop);
	ImGui_ImplGlfw_InitForOpenGL(glfw.window, true);
	if (options.besideStock) browser.key(Key::Halves);
	browser.open(options.first);
	applyChoices(options.show, browser.choice());
	if (!options.device.empty())
	{
		auto device = DeviceHand::open(options.device);
		if (!device) return ImGui_ImplGlfw_Shutdown(), device.error();
		browser.use(std::move(device).value());
		if (options.forces) browser.feelForces();
	}
	loop(glfw.window, browser, gui, options);
	ImGui_ImplGlfw_Shutdown();
	return std::nullopt;
}
}  // namespace browser

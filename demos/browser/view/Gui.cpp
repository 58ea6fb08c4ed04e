// SPDX-License-Identifier: Zlib
#include "demos/browser/view/Gui.h"

#include "demos/browser/render/Gl.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>
#include <imgui_internal.h>  // ImRect

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <vector>

namespace browser
{
namespace
{
constexpr float kTextHeight = 15;

void setColours()
{
	ImGui::StyleColorsLight();
	ImGuiStyle& style = ImGui::GetStyle();
	style.WindowRounding = style.FrameRounding = style.GrabRounding = 4;
	style.WindowBorderSize = 0;
	style.FrameBorderSize = 0;
	style.ItemSpacing = {8, 6};
	ImVec4* c = style.Colors;
	const ImVec4 blue{0.00f, 0.447f, 0.698f, 1}, pale{0.88f, 0.91f, 0.94f, 1};
	c[ImGuiCol_WindowBg] = {0.975f, 0.98f, 0.985f, 0.97f};
	c[ImGuiCol_Text] = {0.10f, 0.11f, 0.13f, 1};
	c[ImGuiCol_TitleBg] = c[ImGuiCol_TitleBgActive] = c[ImGuiCol_TitleBgCollapsed] = {0.82f, 0.87f, 0.92f, 1};
	c[ImGuiCol_FrameBg] = {0.90f, 0.92f, 0.945f, 1};
	c[ImGuiCol_SliderGrab] = c[ImGuiCol_SliderGrabActive] = c[ImGuiCol_CheckMark] = blue;
	c[ImGuiCol_Header] = {0.75f, 0.86f, 0.95f, 1};
	c[ImGuiCol_HeaderHovered] = {0.82f, 0.90f, 0.96f, 1};
	c[ImGuiCol_HeaderActive] = {0.68f, 0.81f, 0.92f, 1};
	c[ImGuiCol_Button] = pale;
	c[ImGuiCol_ButtonHovered] = {0.80f, 0.88f, 0.95f, 1};
	c[ImGuiCol_ButtonActive] = {0.70f, 0.82f, 0.93f, 1};
	c[ImGuiCol_PlotLines] = c[ImGuiCol_PlotHistogram] = blue;
	c[ImGuiCol_Separator] = {0.80f, 0.83f, 0.87f, 1};
}
}  // namespace

Gui::Gui(double density) : m_density(density > 0.25 && density < 8 ? density : 1)
{
	ImGui::CreateContext();
	ImGuiIO& io = ImGui::GetIO();
	io.IniFilename = nullptr;
	setColours();
	const float height = std::round(kTextHeight * float(m_density));
	std::error_code ignored;
	for (const char* font :
		{"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf"})
		if (io.Fonts->Fonts.empty() && std::filesystem::exists(font, ignored)) io.Fonts->AddFontFromFileTTF(font, height);
	if (io.Fonts->Fonts.empty())
	{
		io.Fonts->AddFontDefault();
		io.FontGlobalScale = float(m_density);
	}
	ImGui::GetStyle().ScaleAllSizes(float(m_density));
	ImGui_ImplOpenGL3_Init("#version 330 core");
}

Gui::~Gui()
{
	ImGui_ImplOpenGL3_Shutdown();
	ImGui::DestroyContext();
}

void Gui::beginOffscreen(int width, int height)
{
	ImGuiIO& io = ImGui::GetIO();
	io.DisplaySize = {float(width), float(height)};
	io.DeltaTime = 1.0f / 60;
	begin();
}

void Gui::begin()
{
	ImGui_ImplOpenGL3_NewFrame();
	ImGui::NewFrame();
}

void Gui::end(unsigned target, int width, int height)
{
	ImGui::Render();
	glBindFramebuffer(GL_FRAMEBUFFER, target);
	glViewport(0, 0, width, height);
	ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

namespace
{
constexpr int kMostMoves = 12;

/// Position for a label of this size whose lower left corner should be at `at`: there, or above the labels in its way. Returns nothing
/// when that would be too far away.
std::optional<ImVec2> freePlace(ImVec2 at, const ImVec2& size, const std::vector<ImRect>& taken)
{
	for (int moves = 0; moves <= kMostMoves; ++moves)
	{
		const ImRect wanted({at.x, at.y - size.y}, {at.x + size.x, at.y});
		const auto other = std::find_if(taken.begin(), taken.end(), [&](const ImRect& t) { return t.Overlaps(wanted); });
		if (other == taken.end()) return at;
		at.y = other->Min.y;
	}
	return std::nullopt;
}
}  // namespace

void drawTexts(ImDrawList& to, const DrawList& list, const Camera& camera, const PixelArea& area)
{
	to.PushClipRect({float(area.left), 0}, {float(area.left + area.width), float(area.height)});
	std::vector<ImRect> taken;
	for (const DrawnText& text : list.texts)
	{
		const auto at = camera.project(text.at, area.aspect());
		if (!at) continue;
		const ImVec2 letters = ImGui::CalcTextSize(text.text.c_str());
		const float pad = 0.25f * letters.y;
		const ImVec2 size{letters.x + 2 * pad, letters.y + 0.8f * pad};
		const auto corner = freePlace({float(area.left + (*at)[0] * area.width), float((*at)[1] * area.height) - 0.6f * pad}, size, taken);
		if (!corner) continue;
		taken.push_back({{corner->x, corner->y - size.y}, {corner->x + size.x, corner->y}});
		to.AddRectFilled(taken.back().Min, taken.back().Max, IM_COL32(255, 255, 255, 205), pad);
		to.AddText({corner->x + pad, corner->y - size.y + 0.4f * pad},
			ImGui::ColorConvertFloat4ToU32({text.colour.r, text.colour.g, text.colour.b, 1}), text.text.c_str());
	}
	to.PopClipRect();
}
}  // namespace browser

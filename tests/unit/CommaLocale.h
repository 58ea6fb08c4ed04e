// SPDX-License-Identifier: Zlib
#pragma once

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <locale>
#include <optional>
#include <string>
#include <utility>

#include "tests/unit/TestEnvironment.h"

/// Makes the whole program write numbers with a decimal comma while it lives, as a host does that calls setlocale(LC_ALL, ""). A locale
/// that the system lacks is compiled by localedef into a folder of its own. `there()` is false where that fails, and then nothing is
/// changed.
class CommaLocale
{
public:
	/// "de_DE", "fr_FR", "tr_TR" and the like.
	explicit CommaLocale(const std::string& name)
	{
		const std::string locale = windowsName(name).value_or(name + ".UTF-8");
		if (std::setlocale(LC_ALL, locale.c_str()) || (compile(name, locale) && std::setlocale(LC_ALL, locale.c_str())))
			m_there = std::string(std::localeconv()->decimal_point) == ",";
		if (!m_there) std::setlocale(LC_ALL, m_before.c_str());
	}
	~CommaLocale()
	{
		std::setlocale(LC_ALL, m_before.c_str());
		if (m_folder.empty()) return;
		unsetenv("LOCPATH");
		std::error_code ignored;
		std::filesystem::remove_all(m_folder, ignored);
	}
	CommaLocale(const CommaLocale&) = delete;
	CommaLocale& operator=(const CommaLocale&) = delete;

	bool there() const { return m_there; }

private:
	/// What Windows calls a locale; nothing elsewhere.
	static std::optional<std::string> windowsName([[maybe_unused]] const std::string& name)
	{
#if defined(_WIN32)
		if (name == "de_DE") return "German_Germany";
		if (name == "fr_FR") return "French_France";
		if (name == "tr_TR") return "Turkish_Turkey";
#endif
		return std::nullopt;
	}
	bool compile(const std::string& name, const std::string& locale)
	{
		m_folder = (std::filesystem::temp_directory_path() / ("ist_locale_" + std::to_string(getpid()))).string();
		std::filesystem::create_directories(m_folder);
		const std::string command = "localedef -i " + name + " -f UTF-8 '" + m_folder + "/" + locale + "' > /dev/null 2>&1";
		return std::system(command.c_str()) == 0 && setenv("LOCPATH", m_folder.c_str(), 1) == 0;
	}

	std::string m_before = std::setlocale(LC_ALL, nullptr), m_folder;
	bool m_there = false;
};

/// Which locale this thread has: the program's, or one of its own.
inline auto localeOfThread()
{
#if defined(_WIN32)
	return std::pair(_configthreadlocale(0), std::string(std::setlocale(LC_ALL, nullptr)));
#else
	return uselocale(nullptr);
#endif
}

/// Gives this thread the locale "C" while it lives, and leaves the program's as it is.
class PlainThreadLocale
{
public:
#if defined(_WIN32)
	PlainThreadLocale() : m_before(_configthreadlocale(_ENABLE_PER_THREAD_LOCALE)) { std::setlocale(LC_ALL, "C"); }
	~PlainThreadLocale() { _configthreadlocale(m_before); }
#else
	PlainThreadLocale() : m_own(newlocale(LC_ALL_MASK, "C", nullptr)) { uselocale(m_own); }
	~PlainThreadLocale()
	{
		uselocale(LC_GLOBAL_LOCALE);
		freelocale(m_own);
	}
#endif
	PlainThreadLocale(const PlainThreadLocale&) = delete;
	PlainThreadLocale& operator=(const PlainThreadLocale&) = delete;

private:
#if defined(_WIN32)
	int m_before;
#else
	locale_t m_own;
#endif
};

/// Makes the streams of C++ write and read numbers as 1.234,5 while it lives, as a host does that calls std::locale::global.
class CommaStreams
{
public:
	CommaStreams() : m_before(std::locale::global(std::locale(std::locale::classic(), new Punctuation))) {}
	~CommaStreams() { std::locale::global(m_before); }
	CommaStreams(const CommaStreams&) = delete;
	CommaStreams& operator=(const CommaStreams&) = delete;

private:
	struct Punctuation : std::numpunct<char>
	{
		char do_decimal_point() const override { return ','; }
		char do_thousands_sep() const override { return '.'; }
		std::string do_grouping() const override { return "\3"; }
	};
	std::locale m_before;
};

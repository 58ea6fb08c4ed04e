// SPDX-License-Identifier: Zlib
// Plug-in for QEMU's user mode that prints, at the end, how many instructions the program executed.
// Build: gcc -shared -fPIC -O2 qemu_instructions.c -o qemu_instructions.so
// Use: qemu-aarch64 -plugin ./qemu_instructions.so -L SYSROOT PROGRAM
#include <inttypes.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

// The part of <qemu-plugin.h>, interface version 1, that is used here: Debian has QEMU, but not this header.
struct qemu_plugin_tb;
enum qemu_plugin_op
{
	QEMU_PLUGIN_INLINE_ADD_U64
};
void qemu_plugin_register_vcpu_tb_trans_cb(uint64_t id, void (*call)(uint64_t id, struct qemu_plugin_tb* block));
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);
void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb* block, enum qemu_plugin_op op, void* number, uint64_t by);
void qemu_plugin_register_atexit_cb(uint64_t id, void (*call)(uint64_t id, void* data), void* data);

int qemu_plugin_version = 1;
static uint64_t count;

static void onBlock(uint64_t id, struct qemu_plugin_tb* block)
{
	(void)id;
	qemu_plugin_register_vcpu_tb_exec_inline(block, QEMU_PLUGIN_INLINE_ADD_U64, &count, qemu_plugin_tb_n_insns(block));
}

static void onExit(uint64_t id, void* data)
{
	(void)id, (void)data;
	fprintf(stderr, "instructions: %" PRIu64 "\n", count);
}

int qemu_plugin_install(uint64_t id, const void* info, int argc, char** argv)
{
	(void)info, (void)argc, (void)argv;
	qemu_plugin_register_vcpu_tb_trans_cb(id, onBlock);
	qemu_plugin_register_atexit_cb(id, onExit, NULL);
	return 0;
}

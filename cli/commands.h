/* cli/commands.h: one function per command. argv[0] is the command's name; returns the exit status.
 */
#ifndef CLI_COMMANDS_H
#define CLI_COMMANDS_H

int command_render(int argc, char **argv);
int command_compare(int argc, char **argv);
int command_bench(int argc, char **argv);
int command_shadow(int argc, char **argv);
int command_info(int argc, char **argv);
int command_methods(int argc, char **argv);
int command_scenes(int argc, char **argv);
int command_view(int argc, char **argv);

#endif

/* cli/main.c */
#include <penumbra/penumbra.h>

#include <stdio.h>

int main(void)
{
    printf("penumbra %s\n", pnb_version());
    return 0;
}

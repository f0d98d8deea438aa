within MacroStep;
package Vehicle "Blocks of the plant socket"
end Vehicle;
